#include "pca9685_model.h"

#include <avr_twi.h>

namespace {

enum { FROM_BUS, TO_BUS, IRQS };
const char* const IRQ_NAMES[IRQS] = {"32<pca9685.in", "32>pca9685.out"};

constexpr uint8_t MODE1 = 0x00;
constexpr uint8_t SLEEP = 0x10;
constexpr uint8_t AUTO_INCREMENT = 0x20;
constexpr uint8_t LED0 = 0x06;
constexpr uint8_t ALL_LED = 0xFA;
constexpr uint8_t PRE_SCALE = 0xFE;
constexpr uint8_t FULL = 0x10;
constexpr int CHANNELS = 16;

}  // namespace

Pca9685Model::Pca9685Model(avr_t* avr, uint8_t address) : address_(address) {
  registers_[MODE1] = SLEEP | 0x01;
  registers_[PRE_SCALE] = 0x1E;
  for (int channel = 0; channel < CHANNELS; ++channel) registers_[LED0 + 4 * channel + 3] = FULL;
  irq_ = avr_alloc_irq(&avr->irq_pool, 0, IRQS, const_cast<const char**>(IRQ_NAMES));
  avr_irq_register_notify(irq_ + FROM_BUS, onMessage, this);
  avr_connect_irq(irq_ + TO_BUS, avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_INPUT));
  avr_connect_irq(avr_io_getirq(avr, AVR_IOCTL_TWI_GETIRQ(0), TWI_IRQ_OUTPUT), irq_ + FROM_BUS);
}

int Pca9685Model::duty(int channel) const {
  const uint8_t* led = registers_ + LED0 + 4 * channel;
  if (registers_[MODE1] & SLEEP || led[3] & FULL) return 0;
  if (led[1] & FULL) return 4096;
  const int on = led[0] | (led[1] & 0x0F) << 8;
  const int off = led[2] | (led[3] & 0x0F) << 8;
  return (off - on + 4096) % 4096;
}

void Pca9685Model::onMessage(avr_irq_t*, uint32_t value, void* self) {
  static_cast<Pca9685Model*>(self)->take(value);
}

void Pca9685Model::take(uint32_t value) {
  avr_twi_msg_irq_t message;
  message.u.v = value;
  const uint8_t kind = message.u.twi.msg;
  if (kind & TWI_COND_STOP) selected_ = false;
  if (kind & TWI_COND_START) {
    selected_ = connected && message.u.twi.addr >> 1 == address_;
    const bool reads = message.u.twi.addr & 1;
    has_pointer_ = reads;
    if (selected_) reply(TWI_COND_ACK, 1);
  }
  if (!selected_) return;
  if (kind & TWI_COND_WRITE) {
    reply(TWI_COND_ACK, 1);
    if (has_pointer_) {
      store(message.u.twi.data);
    } else {
      pointer_ = message.u.twi.data;
      has_pointer_ = true;
    }
  }
  if (kind & TWI_COND_READ) {
    reply(TWI_COND_READ, registers_[pointer_]);
    if (registers_[MODE1] & AUTO_INCREMENT) ++pointer_;
  }
}

void Pca9685Model::store(uint8_t value) {
  if (pointer_ >= ALL_LED && pointer_ < PRE_SCALE) {
    for (int channel = 0; channel < CHANNELS; ++channel) registers_[LED0 + 4 * channel + pointer_ - ALL_LED] = value;
  } else if (pointer_ != PRE_SCALE || registers_[MODE1] & SLEEP) {
    registers_[pointer_] = value;
  }
  if (registers_[MODE1] & AUTO_INCREMENT) ++pointer_;
}

void Pca9685Model::reply(uint8_t message, uint8_t data) {
  avr_raise_irq(irq_ + TO_BUS, avr_twi_irq_msg(message, static_cast<uint8_t>(address_ << 1), data));
}
