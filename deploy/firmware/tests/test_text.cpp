// Lines are sent whole or not at all.
#include <string>

#include "check.h"
#include "text.h"

using namespace firmware;

static std::string text(const LineBuilder& line) { return std::string(line.text(), line.length()); }

TEST(numbers_are_written_as_they_are) {
  CHECK_EQ(text(LineBuilder().add(0).add(",").add(-1).add(",").add(1000)), std::string("0,-1,1000"));
  CHECK_EQ(text(LineBuilder().add(INT32_MIN).add(INT32_MAX)), std::string("-21474836482147483647"));
}

TEST(a_line_is_cut_at_its_greatest_length) {
  LineBuilder line;
  for (int i = 0; i < 50; ++i) line.add("abcd");
  CHECK_EQ(static_cast<int>(line.length()), static_cast<int>(MAX_LINE_BYTES));
}

TEST(foreign_bytes_are_made_printable) {
  const uint8_t bytes[] = {'A', 0, '\n', 0x7F, 0xFF, ',', '~'};
  CHECK_EQ(text(LineBuilder().addForeign(bytes, sizeof bytes)), std::string("A????,~"));
}

TEST(a_full_queue_drops_whole_lines_and_counts_them) {
  TxQueue queue;
  LineBuilder line;
  line.add("0123456789012345678901234567890");  // 31 and the newline
  for (int i = 0; i < 8; ++i) CHECK(queue.put(line));
  CHECK_EQ(queue.used(), TxQueue::CAPACITY);
  CHECK(!queue.put(line));
  CHECK_EQ(queue.dropped(), 1);
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 31; ++j) CHECK_EQ(queue.pop(), static_cast<uint8_t>('0' + j % 10));
    CHECK_EQ(queue.pop(), '\n');
  }
  CHECK(queue.empty());
  CHECK_EQ(queue.pop(), 0);
}

TEST(a_reserve_stays_free) {
  TxQueue queue;
  LineBuilder line;
  line.add("x");
  CHECK(queue.put(line, TxQueue::CAPACITY - 2));
  CHECK(!queue.put(line, TxQueue::CAPACITY - 2));
  CHECK(queue.put(line, TxQueue::CAPACITY - 4));
}

TEST(the_queue_wraps_round) {
  TxQueue queue;
  LineBuilder line;
  line.add("abc");
  for (int i = 0; i < 1000; ++i) {
    CHECK(queue.put(line));
    CHECK_EQ(queue.pop(), 'a');
    CHECK_EQ(queue.pop(), 'b');
    CHECK_EQ(queue.pop(), 'c');
    CHECK_EQ(queue.pop(), '\n');
  }
}
