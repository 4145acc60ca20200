#include "verbs/common/page_settings.hpp"

#include <fmt/format.h>

#include <string_view>

namespace biss::verbs {

namespace {

std::string link_value(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                       std::string_view("-._~").find(c) != std::string_view::npos;
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

std::string quoted(const std::string& word) {
  if (!word.empty() && word.find_first_of(" \t\r\n'\"") == std::string::npos) return word;
  std::string text = "\"";
  for (const char c : word) text += c == '"' ? "\"'\"'\"" : std::string(1, c);
  return text + '"';
}

// The page has one file, and names a line without it.
std::string line_name(const std::string& value, const std::vector<std::string>& files) {
  for (const std::string& path : files) {
    for (const std::string& file : {path, path.substr(path.rfind('/') + 1)}) {
      if (value.starts_with(file + ':')) return value.substr(file.size() + 1);
    }
  }
  return value;
}

}  // namespace

std::string PageSettings::further_text() const {
  std::string text;
  for (const PageOption& option : further) {
    for (const std::string& word : option.words) text += (text.empty() ? "" : " ") + quoted(word);
  }
  return text;
}

std::string PageSettings::link_text() const {
  std::string text;
  const auto put = [&](std::string_view name, std::string_view value) {
    if (value.empty()) return;
    text += fmt::format("{}{}={}", text.empty() ? "" : "&", name, link_value(value));
  };
  put("format", format);
  put("ma", ma);
  put("slo", slo);
  put("units", units);
  put("invert", invert_ma && invert_slo ? "ma,slo" : invert_ma ? "ma" : invert_slo ? "slo" : "");
  put("further", further_text());
  return text;
}

PageSettings page_settings(const std::vector<Option>& given) {
  PageSettings settings;
  std::vector<std::string> files;
  for (const Option& option : given) {
    if (option.name() == "FILE") files = option.values();
  }
  for (const Option& option : given) {
    const std::string name = option.name();
    const std::vector<std::string> values = option.values();
    if (option.scope() == Scope::command) continue;
    if (name == "--format") {
      settings.format = values.back();
    } else if (name == "--ma" || name == "--slo") {
      (name == "--ma" ? settings.ma : settings.slo) = line_name(values.back(), files);
    } else if (name == "--invert-ma") {
      settings.invert_ma = true;
    } else if (name == "--invert-slo") {
      settings.invert_slo = true;
    } else if (name == "--scale" && (values.back() == "deg" || values.back() == "mm")) {
      settings.units = values.back();
    } else {
      auto& words = settings.further.emplace_back(PageOption{option.scope(), {name}}).words;
      // The value of a flag is "true".
      if (values != std::vector<std::string>{"true"}) {
        words.insert(words.end(), values.begin(), values.end());
      }
    }
  }
  return settings;
}

}  // namespace biss::verbs
