#include "serial_port.h"

#include <fcntl.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <stdexcept>

#include <avr_uart.h>

namespace {

constexpr size_t MOST_WAITING = 4096;

}  // namespace

void quietUart(avr_t* avr) {
  uint32_t flags = 0;
  avr_ioctl(avr, AVR_IOCTL_UART_GET_FLAGS('0'), &flags);
  flags &= ~static_cast<uint32_t>(AVR_UART_FLAG_STDIO | AVR_UART_FLAG_POOL_SLEEP);
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
}

SerialPort::SerialPort(avr_t* avr) {
  termios raw = {};
  cfmakeraw(&raw);
  char name[64];
  if (openpty(&master_, &slave_, name, &raw, nullptr) != 0) throw std::runtime_error("no pseudo-terminal is to be had");
  name_ = name;
  fcntl(master_, F_SETFL, O_NONBLOCK);
  quietUart(avr);
  input_ = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), onOutput, this);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF), onBusy, this);
  avr_irq_register_notify(avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON), onReady, this);
}

SerialPort::~SerialPort() {
  close(slave_);
  close(master_);
}

void SerialPort::pump() {
  uint8_t bytes[512];
  while (to_chip_.size() < MOST_WAITING) {
    const ssize_t count = read(master_, bytes, sizeof bytes);
    if (count <= 0) break;
    to_chip_.insert(to_chip_.end(), bytes, bytes + count);
  }
  if (from_chip_.empty()) return;
  const ssize_t sent = write(master_, from_chip_.data(), from_chip_.size());
  // What nobody reads is lost, as on a wire.
  bytes_lost += from_chip_.size() - static_cast<size_t>(sent > 0 ? sent : 0);
  from_chip_.clear();
}

void SerialPort::deliver() {
  if (to_chip_.empty() || busy_) return;
  const uint8_t byte = to_chip_.front();
  to_chip_.pop_front();
  ++bytes_in;
  avr_raise_irq(input_, byte);
}

void SerialPort::onOutput(avr_irq_t*, uint32_t value, void* self) {
  SerialPort* port = static_cast<SerialPort*>(self);
  ++port->bytes_out;
  port->from_chip_ += static_cast<char>(value);
}

void SerialPort::onBusy(avr_irq_t*, uint32_t value, void* self) {
  if (value != 0) static_cast<SerialPort*>(self)->busy_ = true;
}

void SerialPort::onReady(avr_irq_t*, uint32_t value, void* self) {
  if (value != 0) static_cast<SerialPort*>(self)->busy_ = false;
}
