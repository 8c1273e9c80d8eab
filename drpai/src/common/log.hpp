// One line an event on stderr, in the form of the Python processes, so that the merged log is in order.
#pragma once

#include <string_view>

namespace yolo_cam::log {

void info(std::string_view text);
void warning(std::string_view text);
void error(std::string_view text);

}  // namespace yolo_cam::log
