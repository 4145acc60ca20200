// Stands in for the header of Saleae's SDK in our test: see LogicPublicTypes.h.
#pragma once

#include <LogicPublicTypes.h>

#include <sstream>
#include <string>

/// Values as lines of text.
class SimpleArchive {
 public:
  void SetString(const char* text) { text_.str(text); }
  const char* GetString() {
    whole_ = text_.str();
    return whole_.c_str();
  }
  bool operator<<(const char* value) { return put(value); }
  bool operator<<(bool value) { return put(value ? "1" : "0"); }
  bool operator<<(Channel& value) { return put(std::to_string(value.mChannelIndex)); }
  bool operator>>(char const** value) {
    if (!take()) return false;
    *value = line_.c_str();
    return true;
  }
  bool operator>>(bool& value) {
    std::string line;
    if (!std::getline(text_, line)) return false;
    value = line == "1";
    return true;
  }
  bool operator>>(Channel& value) {
    std::string line;
    if (!std::getline(text_, line)) return false;
    value = Channel(0, static_cast<U32>(std::strtoul(line.c_str(), nullptr, 10)), DIGITAL_CHANNEL);
    return true;
  }

 private:
  bool put(const std::string& value) {
    text_ << value << '\n';
    return true;
  }
  bool take() { return static_cast<bool>(std::getline(text_, line_)); }

  std::stringstream text_;
  std::string line_;
  std::string whole_;
};
