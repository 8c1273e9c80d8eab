// One picture after the other: take, straighten, look, tell.
#pragma once

#include <optional>
#include <string>

#include "app/options.hpp"
#include "app/watchdog.hpp"
#include "common/latency.hpp"
#include "detect/inference_backend.hpp"
#include "detect/letterbox.hpp"
#include "detect/undistort.hpp"
#include "ipc/channel_reader.hpp"
#include "ipc/channel_writer.hpp"
#include "source/frame_source.hpp"

namespace yolo_cam {

class DetectorLoop {
 public:
  // Throws DeviceError: another detector writes the channels.
  DetectorLoop(const Options& options, FrameSource& source, InferenceBackend& backend, Watchdog& watchdog);

  // At most one picture; whether there was one.
  // Throws DeviceError: pictures of another size than configured, for ranges would be wrong.
  bool step();

  std::optional<std::string> report(double now_s) { return times_.take(now_s); }

 private:
  void follow(const target_nav::ipc::Calibration& calibration);

  Options options_;
  FrameSource& source_;
  InferenceBackend& backend_;
  Watchdog& watchdog_;
  CalibrationReader calibrations_;
  DetectionsWriter detections_;
  PictureWriter pictures_;
  Undistorter undistorter_;
  Letterbox letterbox_;
  StageTimes times_;
  std::optional<Lens> lens_;
  std::string wanted_class_;
};

}  // namespace yolo_cam
