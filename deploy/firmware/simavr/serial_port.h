// UART 0 of the simulated chip on a pseudo-terminal, at the pace of 115200 baud.
//
// simavr's own uart_pty stalls; here the main loop carries the bytes. The terminal's other end is kept open, for
// otherwise the first reader to close it hangs it up.
#pragma once

#include <cstdint>
#include <deque>
#include <string>

#include <sim_avr.h>

class SerialPort {
 public:
  explicit SerialPort(avr_t* avr);
  ~SerialPort();
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  const std::string& name() const { return name_; }
  // Between terminal and buffers; once a millisecond.
  void pump();
  // One byte towards the chip, if it takes one; once in the time of a byte.
  void deliver();

  uint64_t bytes_in = 0;
  uint64_t bytes_out = 0;
  uint64_t bytes_lost = 0;

 private:
  static void onOutput(avr_irq_t* irq, uint32_t value, void* self);
  static void onBusy(avr_irq_t* irq, uint32_t value, void* self);
  static void onReady(avr_irq_t* irq, uint32_t value, void* self);

  avr_irq_t* input_;
  int master_ = -1;
  int slave_ = -1;
  std::string name_;
  std::deque<uint8_t> to_chip_;
  std::string from_chip_;
  bool busy_ = false;
};

// UART 0 without simavr's own printing and sleeping.
void quietUart(avr_t* avr);
