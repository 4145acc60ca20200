// Prints the position of a BiSS C encoder ten times a second, or why it was not measured.
//
// SCK goes to the RS-422 driver of MA, the RS-422 receiver of SLO to MISO (CIPO). Enter the format of
// your encoder: "biss encoders" lists names, docs/format.md describes the text.
#include <BissC.h>

constexpr auto format = biss::frame_format("pos18,nE,nW,crc6");
constexpr biss::SpiSetup line{.period = biss::period_of(biss::megahertz(1)),
                              .line_delay = {.max = biss::microseconds(1)}};
BissReader<format, line> encoder(SPI);

void setup() {
  Serial.begin(115200);
  SPI.begin();
  encoder.begin();
}

void loop() {
  const biss::AxisPosition now = encoder.read();
  if (now.state == biss::AxisState::measured) {
    Serial.println(static_cast<long>(now.position));
  } else {
    Serial.println(biss::name_of(now.cause).data());
  }
  // Four bad readings in a row: a machine stops here. The turns start from 0 again.
  if (now.state == biss::AxisState::tripped) encoder.axis().reset();
  delay(100);
}
