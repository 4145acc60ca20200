// Stands in for the header of Saleae's SDK in our test. It has the parts that the analyzer uses,
// with the names and signatures of the SDK's documentation; the code is our own.
#pragma once

#include <cstdint>

#define __cdecl
#define LOGICAPI
#define ANALYZER_EXPORT __attribute__((visibility("default")))

using U8 = unsigned char;
using U32 = unsigned int;
using U64 = unsigned long long;
using S64 = long long;

enum DisplayBase { Binary, Decimal, Hexadecimal, ASCII, AsciiHex };
enum BitState { BIT_LOW, BIT_HIGH };
enum ChannelDataType { ANALOG_CHANNEL, DIGITAL_CHANNEL };

class Channel {
 public:
  Channel() = default;
  Channel(U64 device, U32 index, ChannelDataType type)
      : mDeviceId(device), mChannelIndex(index), mDataType(type) {}
  bool operator==(const Channel& other) const = default;

  U64 mDeviceId = 0;
  U32 mChannelIndex = 0;
  ChannelDataType mDataType = DIGITAL_CHANNEL;
};

#define UNDEFINED_CHANNEL Channel(0xFFFFFFFFFFFFFFFFull, 0xFFFFFFFF, DIGITAL_CHANNEL)
