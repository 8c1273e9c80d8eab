// Quadrature: whole periods count, trembling does not.
#include "check.h"
#include "encoder.h"

using namespace firmware;

// Channels in the order of turning forward, A leading: 00 10 11 01.
struct Shaft {
  Encoder encoder;
  int phase = 0;

  static bool a(int phase) { return (phase & 3) == 1 || (phase & 3) == 2; }
  static bool b(int phase) { return (phase & 3) == 2 || (phase & 3) == 3; }

  void turn(int steps) {
    for (int i = 0; i < (steps < 0 ? -steps : steps); ++i) {
      const int next = phase + (steps < 0 ? -1 : 1);
      if (a(next) != a(phase)) encoder.edge(a(next), b(next));
      phase = next;
    }
  }
};

TEST(a_period_is_a_count_either_way) {
  Shaft shaft;
  shaft.turn(4 * 990);
  CHECK_EQ(shaft.encoder.count(), 990);
  shaft.turn(-4 * 2000);
  CHECK_EQ(shaft.encoder.count(), -1010);
  shaft.turn(4 * 1010);
  CHECK_EQ(shaft.encoder.count(), 0);
}

TEST(trembling_on_an_edge_does_not_add_up) {
  for (int start = 0; start < 4; ++start) {
    Shaft shaft;
    shaft.turn(400 + start);
    const int32_t before = shaft.encoder.count();
    for (int i = 0; i < 1000; ++i) {
      shaft.turn(1);
      shaft.turn(-1);
    }
    CHECK_EQ(shaft.encoder.count(), before);
  }
}
