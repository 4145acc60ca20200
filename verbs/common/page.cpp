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

std::vector<fs::path> usual_places() {
  std::error_code problem;
  const fs::path command = fs::read_symlink("/proc/self/exe", problem);
  if (problem) return {};
  const fs::path above = command.parent_path().parent_path();
  return {above / "share/biss/biss.html", above / "view/dist/biss.html"};
}

tl::unexpected<VerbError> no_page(std::string text) {
  return tl::unexpected(VerbError{ExitStatus::io, std::move(text)});
}

tl::expected<fs::path, VerbError> find_page() {
  std::string tried;
  for (const fs::path& place : usual_places()) {
    std::error_code problem;
    if (fs::is_regular_file(place, problem)) return place;
    tried += (tried.empty() ? "" : " and ") + place.string();
  }
  return no_page(
      fmt::format("the page biss.html is not there{}{}; build it (make view), or name "
                  "it with --page FILE",
                  tried.empty() ? "" : ": looked for ", tried));
}

}  // namespace

Option add_page_option(Verb verb, std::string& path) {
  return verb.scope(Scope::command)
      .add_option("--page", path,
                  "Page of biss (make view builds it); by default the page that is installed "
                  "with the command, or the page of the build tree")
      .file(FileUse::read);
}

tl::expected<std::string, VerbError> read_page(const std::string& path) {
  fs::path file = path;
  if (path.empty()) {
    const auto found = find_page();
    if (!found) return tl::unexpected(found.error());
    file = *found;
  }
  const auto text = read_text_file(file.string());
  if (!text) return no_page(fmt::format("{}: {}", file.string(), text.error()));
  if (text->find(core_element) == std::string::npos) {
    return no_page(
        fmt::format("{}: is not the page of biss, which make view builds", file.string()));
  }
  return *text;
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

}  // namespace biss::verbs
