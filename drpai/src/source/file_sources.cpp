#include "source/file_sources.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <utility>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/error.hpp"
#include "common/log.hpp"

namespace yolo_cam {
namespace {

// The simulator's pictures are looked for this often.
constexpr double SIM_POLL_S = 0.001;
// Of files that do not say.
constexpr double VIDEO_RATE_HZ = 25.0;

bool is_image(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::array<const char*, 5> KNOWN{".jpg", ".jpeg", ".png", ".bmp", ".webp"};
  return std::find(KNOWN.begin(), KNOWN.end(), ending) != KNOWN.end();
}

// The file readers by name: asked to choose for itself, OpenCV also looks for cameras, and that takes long.
bool open_video(cv::VideoCapture& capture, const std::string& path) {
  constexpr std::array<int, 3> READERS{cv::CAP_FFMPEG, cv::CAP_OPENCV_MJPEG, cv::CAP_GSTREAMER};
  return std::any_of(READERS.begin(), READERS.end(), [&](int reader) { return capture.open(path, reader); });
}

double rate_of(const cv::VideoCapture& capture, double rate_hz) {
  const double own_hz = capture.get(cv::CAP_PROP_FPS);
  return std::min(rate_hz, own_hz > 0.0 && std::isfinite(own_hz) ? own_hz : VIDEO_RATE_HZ);
}

}  // namespace

std::optional<Picture> SharedMemorySource::poll() {
  const double give_up_s = monotonic_s() + POLL_LIMIT_S;
  while (true) {
    if (auto picture = reader_.take_new()) {
      return picture;
    }
    if (monotonic_s() >= give_up_s) {
      return std::nullopt;
    }
    sleep_s(SIM_POLL_S);
  }
}

VideoFileSource::VideoFileSource(std::string path, double rate_hz, bool loop)
    : path_(std::move(path)), pacer_(rate_of(opened(), rate_hz)), loop_(loop) {}

cv::VideoCapture& VideoFileSource::opened() {
  if (!open_video(capture_, path_)) {
    throw DeviceError("video " + path_ + " cannot be opened; is it a video that OpenCV reads?");
  }
  return capture_;
}

std::optional<Picture> VideoFileSource::poll() {
  if (end() || !pacer_.wait()) {
    return std::nullopt;
  }
  Picture picture;
  if (!capture_.read(picture.image_bgr) || picture.image_bgr.empty()) {
    if (!loop_ || count_ == 0) {
      finish(false, "end of " + path_ + " after " + std::to_string(count_) + " pictures");
    } else if (!open_video(capture_, path_)) {
      finish(true, "video " + path_ + " cannot be opened again");
    }
    return std::nullopt;
  }
  picture.stamp_s = monotonic_s();
  picture.frame_id = ++count_;
  return picture;
}

FolderSource::FolderSource(const std::string& folder, int width_px, int height_px, double rate_hz, bool loop)
    : folder_(folder), size_(width_px, height_px), pacer_(rate_hz), loop_(loop) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file() && is_image(entry.path())) {
      paths_.push_back(entry.path().string());
    }
  }
  std::sort(paths_.begin(), paths_.end());
  if (paths_.empty()) {
    throw DeviceError("folder " + folder + " holds no image (.jpg, .png, .bmp, .webp)");
  }
}

std::optional<Picture> FolderSource::poll() {
  if (end() || !pacer_.wait()) {
    return std::nullopt;
  }
  if (next_ == paths_.size()) {
    if (!loop_ || count_ == 0) {
      finish(false, "end of " + folder_ + " after " + std::to_string(count_) + " pictures");
      return std::nullopt;
    }
    next_ = 0;
  }
  const std::string& path = paths_[next_++];
  const cv::Mat image = cv::imread(path, cv::IMREAD_COLOR);
  if (image.empty()) {
    log::warning(path + " is no image that OpenCV reads; left out");
    return std::nullopt;
  }
  Picture picture;
  picture.image_bgr = fitted(image, size_);
  picture.stamp_s = monotonic_s();
  picture.frame_id = ++count_;
  return picture;
}

cv::Mat fitted(const cv::Mat& image, cv::Size size) {
  const double scale = std::max(static_cast<double>(size.width) / image.cols, static_cast<double>(size.height) / image.rows);
  const int width = std::min(image.cols, static_cast<int>(std::lround(size.width / scale)));
  const int height = std::min(image.rows, static_cast<int>(std::lround(size.height / scale)));
  const cv::Mat middle = image(cv::Rect((image.cols - width) / 2, (image.rows - height) / 2, width, height));
  cv::Mat result;
  cv::resize(middle, result, size, 0.0, 0.0, scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return result;
}

}  // namespace yolo_cam
