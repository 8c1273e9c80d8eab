// Runs an image for the ATmega2560 under simavr.
//
//   avr_bench IMAGE.elf             in real time, with motor driver, motors and encoders beside it. Ends with its input.
//   avr_bench --console IMAGE.elf   as fast as it goes, what UART 0 sends on standard output, to its end-of-file (0x04)
//
// In real time, on standard output:
//   port NAME                       of the serial line, once
//   drive T_S FL FR RL RR           the motors' duty from now on, -4095 ... 4095; T_S is CLOCK_MONOTONIC
//   end KEY=VALUE ...               figures of the run
// and on standard input:
//   jam WHEEL  free WHEEL           a wheel (FL ...) is held fast, or not
//   driver off  driver on           the PCA9685's wire is broken, or not
//   hang                            the main loop stays where it is for ever; interrupts go on
#include <fcntl.h>
#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>

#include <avr_uart.h>
#include <sim_avr.h>
#include <sim_elf.h>

#include "config.h"
#include "pca9685_model.h"
#include "serial_port.h"
#include "wheels_model.h"

namespace {

constexpr uint32_t CLOCK_HZ = 16000000;
constexpr avr_cycle_count_t CHUNK_CYCLES = CLOCK_HZ / 1000;
constexpr avr_cycle_count_t WHEELS_CYCLES = static_cast<avr_cycle_count_t>(CLOCK_HZ * WheelsModel::STEP_S);
// simavr counts a parity bit into a byte's time, used or not; slower than that its buffer does not fill.
constexpr avr_cycle_count_t BYTE_CYCLES = 1600;
// So far behind, the time that is lost is let go, or everything after would be early.
constexpr double MOST_BEHIND_S = 0.2;
constexpr uint8_t PAINT = 0xC5;
constexpr uint16_t RAM_START = 0x200;
constexpr char END_OF_FILE = 0x04;

double monotonic_s() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + now.tv_nsec * 1e-9;
}

void sleepUntil(double deadline_s) {
  timespec at;
  at.tv_sec = static_cast<time_t>(deadline_s);
  at.tv_nsec = static_cast<long>((deadline_s - static_cast<double>(at.tv_sec)) * 1e9);
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
}

double cpu_s() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
         static_cast<double>(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec) * 1e-6;
}

// Only errors, for standard output is spoken for.
void logErrors(avr_t*, const int level, const char* format, va_list arguments) {
  if (level <= LOG_ERROR) vfprintf(stderr, format, arguments);
}

struct Chip {
  explicit Chip(const char* image) {
    avr_global_logger_set(logErrors);
    elf_firmware_t firmware;
    memset(&firmware, 0, sizeof firmware);
    if (access(image, R_OK) != 0 || elf_read_firmware(image, &firmware) != 0) {
      throw std::runtime_error(std::string(image) + " is no image that can be read; make avr");
    }
    avr = avr_make_mcu_by_name("atmega2560");
    if (avr == nullptr || avr_init(avr) != 0) throw std::runtime_error("this simavr has no atmega2560");
    avr_load_firmware(avr, &firmware);
    avr->frequency = CLOCK_HZ;
    statics_end = static_cast<uint16_t>(RAM_START + firmware.datasize + firmware.bsssize);
    memset(avr->data + RAM_START, PAINT, avr->ramend + 1u - RAM_START);
  }

  bool runs() const { return avr->state != cpu_Done && avr->state != cpu_Crashed; }

  // From here on the main loop jumps to where it is. Not inside an interrupt, for those have interrupts off.
  void hang() {
    while (avr->sreg[S_I] == 0 && runs()) avr_run(avr);
    avr->flash[avr->pc] = 0xFF;  // rjmp .-2
    avr->flash[avr->pc + 1] = 0xCF;
  }

  // How deep the stack ever was: what lost its paint.
  int stackBytes() const {
    int low = statics_end;
    while (low <= avr->ramend && avr->data[low] == PAINT) ++low;
    return avr->ramend + 1 - low;
  }

  avr_t* avr;
  uint16_t statics_end;
};

// --- as fast as it goes ---

struct Console {
  bool ended = false;
  static void onOutput(avr_irq_t*, uint32_t value, void* self) {
    if (value == END_OF_FILE) {
      static_cast<Console*>(self)->ended = true;
    } else {
      putchar(static_cast<int>(value));
    }
  }
};

int runConsole(const char* image) {
  Chip chip(image);
  quietUart(chip.avr);
  Console console;
  avr_irq_register_notify(avr_io_getirq(chip.avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), Console::onOutput,
                          &console);
  while (!console.ended && chip.runs()) avr_run(chip.avr);
  return console.ended ? 0 : 1;
}

// --- in real time ---

class Bench {
 public:
  explicit Bench(const char* image)
      : chip_(image),
        pca9685_(chip_.avr, firmware::wiring::PCA9685_ADDRESS),
        wheels_(chip_.avr, pca9685_),
        port_(chip_.avr) {
    avr_cycle_timer_register(chip_.avr, WHEELS_CYCLES, onWheels, this);
    avr_cycle_timer_register(chip_.avr, BYTE_CYCLES, onByte, this);
    fcntl(STDIN_FILENO, F_SETFL, O_NONBLOCK);
  }

  int run() {
    printf("port %s\n", port_.name().c_str());
    fflush(stdout);
    const double begin_s = monotonic_s();
    double origin_s = begin_s;
    while (!ended_ && chip_.runs()) {
      const avr_cycle_count_t until = chip_.avr->cycle + CHUNK_CYCLES;
      while (chip_.avr->cycle < until && chip_.runs()) avr_run(chip_.avr);
      port_.pump();
      obey();
      const double due_s = origin_s + static_cast<double>(chip_.avr->cycle) / CLOCK_HZ;
      const double behind_s = monotonic_s() - due_s;
      if (behind_s > most_behind_s_) most_behind_s_ = behind_s;
      if (behind_s > MOST_BEHIND_S) {
        origin_s += behind_s;
        lost_s_ += behind_s;
      } else if (behind_s < 0) {
        sleepUntil(due_s);
      }
    }
    printf("end simulated_s=%.3f wall_s=%.3f cpu_s=%.3f most_behind_ms=%.1f lost_s=%.3f stack_bytes=%d bytes_in=%llu "
           "bytes_out=%llu bytes_lost=%llu crashed=%d\n",
           static_cast<double>(chip_.avr->cycle) / CLOCK_HZ, monotonic_s() - begin_s, cpu_s(), most_behind_s_ * 1e3,
           lost_s_, chip_.stackBytes(), static_cast<unsigned long long>(port_.bytes_in),
           static_cast<unsigned long long>(port_.bytes_out), static_cast<unsigned long long>(port_.bytes_lost),
           chip_.avr->state == cpu_Crashed);
    return chip_.avr->state == cpu_Crashed ? 1 : 0;
  }

 private:
  static avr_cycle_count_t onWheels(avr_t*, avr_cycle_count_t when, void* self) {
    Bench* bench = static_cast<Bench*>(self);
    bench->wheels_.step();
    bench->tellDrive();
    return when + WHEELS_CYCLES;
  }

  static avr_cycle_count_t onByte(avr_t*, avr_cycle_count_t when, void* self) {
    static_cast<Bench*>(self)->port_.deliver();
    return when + BYTE_CYCLES;
  }

  void tellDrive() {
    int now[firmware::WHEELS];
    wheels_.drives(now);
    if (memcmp(now, told_, sizeof now) == 0) return;
    memcpy(told_, now, sizeof now);
    printf("drive %.6f %d %d %d %d\n", monotonic_s(), now[0], now[1], now[2], now[3]);
    fflush(stdout);
  }

  void obey() {
    char bytes[256];
    const ssize_t count = read(STDIN_FILENO, bytes, sizeof bytes);
    if (count == 0) ended_ = true;
    for (ssize_t i = 0; i < count; ++i) {
      if (bytes[i] != '\n') {
        typed_ += bytes[i];
        continue;
      }
      if (!obeyLine()) fprintf(stderr, "unknown: %s\n", typed_.c_str());
      typed_.clear();
    }
  }

  bool obeyLine() {
    if (typed_ == "driver off" || typed_ == "driver on") {
      pca9685_.connected = typed_ == "driver on";
      return true;
    }
    if (typed_ == "hang") {
      chip_.hang();
      return true;
    }
    for (int i = 0; i < firmware::WHEELS; ++i) {
      const std::string wheel = firmware::WHEEL_NAMES[i];
      if (typed_ != "jam " + wheel && typed_ != "free " + wheel) continue;
      wheels_.jammed[i] = typed_[0] == 'j';
      return true;
    }
    return false;
  }

  Chip chip_;
  Pca9685Model pca9685_;
  WheelsModel wheels_;
  SerialPort port_;
  int told_[firmware::WHEELS] = {};
  std::string typed_;
  bool ended_ = false;
  double most_behind_s_ = 0.0;
  double lost_s_ = 0.0;
};

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc == 3 && strcmp(argv[1], "--console") == 0) return runConsole(argv[2]);
    if (argc == 2 && argv[1][0] != '-') return Bench(argv[1]).run();
  } catch (const std::exception& error) {
    fprintf(stderr, "avr_bench: %s\n", error.what());
    return 2;
  }
  fprintf(stderr, "usage: avr_bench [--console] IMAGE.elf\n");
  return 2;
}
