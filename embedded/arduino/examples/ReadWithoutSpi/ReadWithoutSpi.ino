// Prints the position of a BiSS C encoder that is read with two pins, without SPI. An interrupt may
// come at any time: if it pauses MA for too long, "failed" is printed.
//
// Pin 2 goes to the RS-422 driver of MA, the RS-422 receiver of SLO to pin 3.
#include <BissC.h>

constexpr int ma_pin = 2;
constexpr int slo_pin = 3;

struct Pins {
  static constexpr biss::Picoseconds time_step = biss::microseconds(1);
  void set_ma(bool level) { digitalWrite(ma_pin, level ? HIGH : LOW); }
  bool slo() { return digitalRead(slo_pin) == HIGH; }
  biss::Picoseconds now() { return biss::microseconds(micros()); }
};

constexpr auto format = biss::frame_format("pos18,nE,nW,crc6");
// Nothing is known of the encoder's timeout, so a pause must be shorter than 1.5 periods.
constexpr biss::SpiSetup line{.period = biss::microseconds(8),
                              .line_delay = {.max = biss::microseconds(1)},
                              .max_pause = biss::nanoseconds(11'900)};
Pins pins;
BissReader<format, line, Pins> encoder(pins);

void setup() {
  Serial.begin(115200);
  digitalWrite(ma_pin, HIGH);
  pinMode(ma_pin, OUTPUT);
  pinMode(slo_pin, INPUT);
}

void loop() {
  const biss::AxisPosition now = encoder.read();
  if (now.state == biss::AxisState::measured) {
    Serial.println(static_cast<long>(now.position));
  } else {
    Serial.println(biss::name_of(now.cause).data());
  }
  if (now.state == biss::AxisState::tripped) encoder.axis().reset();
  delay(100);
}
