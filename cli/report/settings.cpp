#include "cli/report/settings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

namespace biss::cli {

namespace {

// As a form in a page writes it.
std::string link_value(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    const bool plain = code < 0x80 && std::isalnum(code) != 0;
    if (plain || c == '-' || c == '_' || c == '.') {
      out += c;
    } else {
      out += fmt::format("%{:02X}", code);
    }
  }
  return out;
}

std::string quoted(const std::string& word) {
  if (word.find_first_of(" \t\n'\"") == std::string::npos) return word;
  const char mark = word.find('\'') == std::string::npos ? '\'' : '"';
  return mark + word + mark;
}

// The page's name of a line: without the file that it is from, of which there is one.
std::string line_name(const std::string& value) {
  const std::size_t colon = value.rfind(':');
  return colon == std::string::npos ? value : value.substr(colon + 1);
}

}  // namespace

std::string ViewSettings::further_text() const {
  std::string text;
  for (const std::string& word : further) text += (text.empty() ? "" : " ") + quoted(word);
  return text;
}

std::string ViewSettings::link_text() const {
  std::string text;
  const auto put = [&](std::string_view name, std::string_view value) {
    if (value.empty()) return;
    text += fmt::format("{}{}={}", text.empty() ? "" : "&", name, link_value(value));
  };
  put("format", format);
  put("ma", ma);
  put("slo", slo);
  put("invert", invert_ma && invert_slo ? "ma,slo" : invert_ma ? "ma" : invert_slo ? "slo" : "");
  put("further", further_text());
  return text;
}

ViewSettings view_settings(const Verb& verb) {
  ViewSettings settings;
  const std::array<std::pair<std::string_view, std::string*>, 3> texts{
      {{"--format", &settings.format}, {"--ma", &settings.ma}, {"--slo", &settings.slo}}};
  for (const Option& option : verb.given_options()) {
    const std::string name = option.name();
    if (!name.starts_with("-") || name == "--output" || name == "--page") continue;
    const auto text = std::find_if(texts.begin(), texts.end(),
                                   [&](const auto& each) { return each.first == name; });
    if (text != texts.end()) {
      const std::string value = option.values().back();
      *text->second = name == "--format" ? value : line_name(value);
    } else if (name == "--invert-ma") {
      settings.invert_ma = true;
    } else if (name == "--invert-slo") {
      settings.invert_slo = true;
    } else {
      for (const std::string& value : option.values()) {
        settings.further.push_back(name);
        settings.further.push_back(value);
      }
    }
  }
  return settings;
}

}  // namespace biss::cli
