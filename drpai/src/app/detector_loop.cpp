#include "app/detector_loop.hpp"

#include <algorithm>
#include <cmath>

#include "common/clock.hpp"
#include "common/error.hpp"
#include "common/log.hpp"
#include "detect/decoder.hpp"

namespace yolo_cam {

DetectorLoop::DetectorLoop(const Options& options, FrameSource& source, InferenceBackend& backend, Watchdog& watchdog)
    : options_(options),
      source_(source),
      backend_(backend),
      watchdog_(watchdog),
      calibrations_(options.source.prefix),
      detections_(options.source.prefix),
      pictures_(options.source.prefix),
      times_(options.report_every_s, monotonic_s()) {}

bool DetectorLoop::step() {
  watchdog_.beat("waiting for a picture");
  if (const auto calibration = calibrations_.take_new()) {
    follow(*calibration);
  }
  const auto picture = source_.poll();
  if (!picture) {
    return false;
  }
  const double begin_s = monotonic_s();
  if (picture->image_bgr.cols != options_.source.width_px || picture->image_bgr.rows != options_.source.height_px) {
    throw DeviceError("pictures are " + std::to_string(picture->image_bgr.cols) + "x" + std::to_string(picture->image_bgr.rows) +
                      ", the configuration has " + std::to_string(options_.source.width_px) + "x" +
                      std::to_string(options_.source.height_px) +
                      ": set camera.width_px, camera.height_px and the focal_px that belongs to them");
  }
  double mark_s = begin_s;
  const auto lap = [&](Stage stage) {
    const double now_s = monotonic_s();
    times_.add(stage, now_s - mark_s);
    mark_s = now_s;
  };
  times_.add(Stage::Arrive, begin_s - picture->stamp_s);
  watchdog_.beat("preparing a picture");
  const cv::Mat& image = undistorter_.apply(picture->image_bgr, lens_);
  lap(Stage::Undistort);
  const float* input = letterbox_.prepare(image);
  lap(Stage::Prepare);
  watchdog_.beat("running the network");
  const auto& heads = backend_.run(input);
  lap(Stage::Infer);
  watchdog_.beat("writing boxes and picture");
  const auto boxes = decode(heads, letterbox_.placement(), image.cols, image.rows, options_.limits);
  lap(Stage::Decode);
  // Boxes first: the robot waits for them, a person for the picture.
  detections_.write(picture->stamp_s, picture->frame_id, boxes, options_.class_name);
  times_.add(Stage::Total, monotonic_s() - picture->stamp_s);
  pictures_.write(picture->stamp_s, picture->frame_id, image);
  lap(Stage::Publish);
  return true;
}

void DetectorLoop::follow(const target_nav::ipc::Calibration& calibration) {
  Lens lens{calibration.focal_x_px, calibration.focal_y_px, calibration.center_u_px, calibration.center_v_px, {}};
  std::copy(std::begin(calibration.distortion), std::end(calibration.distortion), lens.distortion.begin());
  if (!lens.valid() || !(calibration.score_min >= 0.0 && calibration.score_min <= 1.0)) {
    log::warning("a calibration with numbers that are none is left aside; see the camera process's configuration");
    return;
  }
  if (!lens_ || !(*lens_ == lens)) {
    log::info(lens.distorts() ? "new lens: pictures are straightened" : "new lens: a pinhole, pictures stay as they are");
  }
  lens_ = lens;
  options_.limits.score_min = calibration.score_min;
  const std::string wanted = calibration.class_name;
  if (wanted != wanted_class_) {
    wanted_class_ = wanted;
    if (wanted == options_.class_name) {
      log::info("looking for " + wanted);
    } else {
      log::warning("the mission wants '" + wanted + "'; this network finds only " + options_.class_name);
    }
  }
}

}  // namespace yolo_cam
