#include "verbs/common/page.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "draw/svg.hpp"
#include "verbs/common/text_file.hpp"

namespace biss::verbs {

namespace {

namespace fs = std::filesystem;

// The capture comes before the core, so that the browser has it when the page's script runs.
constexpr std::string_view core_element = R"(<script type="text/plain" id="biss-core">)";

fs::path find_page() {
  std::error_code problem;
  const fs::path above = fs::read_symlink("/proc/self/exe", problem).parent_path().parent_path();
  std::string tried;
  for (const char* const name : {"share/biss/biss.html", "view/dist/biss.html"}) {
    const fs::path place = above / name;
    if (!above.empty() && fs::is_regular_file(place, problem)) return place;
    if (!above.empty()) tried += (tried.empty() ? "" : " and ") + place.string();
  }
  throw wrong_file(
      "the page biss.html is not there{}{}; build it (make view), or name it with --page FILE",
      tried.empty() ? "" : ": looked for ", tried);
}

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

Option& add_page_option(Verb verb, std::string& path) {
  return verb.scope(Scope::command)
      .add_option("--page", path,
                  "Page of biss (make view builds it); by default the page that is installed "
                  "with the command, or the page of the build tree")
      .file(FileUse::read);
}

std::string read_page(const std::string& path) {
  const std::string file = path.empty() ? find_page().string() : path;
  auto text = read_text_file(file);
  if (!text) throw wrong_file("{}: {}", file, text.error());
  if (text->find(core_element) == std::string::npos) {
    throw wrong_file("{}: is not the page of biss, which make view builds", file);
  }
  return *std::move(text);
}

std::string page_with(std::string_view page, std::string_view id,
                      std::initializer_list<PageAttribute> attributes, std::string_view content) {
  const std::size_t place = page.find(core_element);
  std::string element = fmt::format("<script type=\"text/plain\" id=\"{}\"", id);
  for (const PageAttribute& attribute : attributes) {
    element += fmt::format(" data-{}=\"{}\"", attribute.name, draw::markup_text(attribute.value));
  }
  std::string text;
  text.reserve(page.size() + element.size() + content.size() + 16);
  text.append(page.substr(0, place)).append(element).append(">").append(content);
  return text.append("</script>").append(page.substr(place));
}

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

PageSettings page_settings(const std::vector<const Option*>& given) {
  PageSettings settings;
  std::vector<std::string> files;
  for (const Option* option : given) {
    if (option->name() == "FILE") files = option->given;
  }
  for (const Option* option : given) {
    const std::string name = option->name();
    const std::vector<std::string>& values = option->given;
    if (option->scope == Scope::command) continue;
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
      auto& words = settings.further.emplace_back(PageOption{option->scope, {name}}).words;
      // The value of a flag is "true".
      if (values != std::vector<std::string>{"true"}) {
        words.insert(words.end(), values.begin(), values.end());
      }
    }
  }
  return settings;
}

}  // namespace biss::verbs
