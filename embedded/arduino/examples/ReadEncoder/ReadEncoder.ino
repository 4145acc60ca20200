// Prints the position of a BiSS C encoder ten times a second.
//
// SCK goes to the RS-422 driver of MA, the RS-422 receiver of SLO to MISO (CIPO). Enter the format of
// your encoder: "biss encoders" lists names, docs/format.md describes the text.
#include <BissC.h>

constexpr auto format = biss::frame_format("pos18,nE,nW,crc6");
BissReader<format> encoder(SPI, 1000000);

void setup() {
  Serial.begin(115200);
  encoder.begin();
}

void loop() {
  const BissReading reading = encoder.read();
  if (reading.trusted()) {
    Serial.println(static_cast<unsigned long>(reading.position));
  } else {
    Serial.println(reading.cause());
  }
  delay(100);
}
