#include "verbs/common/terminal.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <utility>

#include "report/text.hpp"
#include "verbs/common/host.hpp"

namespace biss::verbs {
namespace {

constexpr auto first_after = std::chrono::seconds(1);
constexpr auto then_every = std::chrono::milliseconds(200);

std::atomic<bool> line_shown = false;

void write_stderr(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

std::size_t terminal_columns(int descriptor) {
  if (descriptor < 0 || ::isatty(descriptor) != 1) return 0;
  winsize size{};
  return ::ioctl(descriptor, TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

std::string cut_off(std::string_view text, std::size_t columns) {
  std::string printable;
  report::append_printable(printable, text);
  while (report::display_width(printable) > columns) {
    // All bytes of a character.
    while ((static_cast<unsigned char>(printable.back()) & 0xC0U) == 0x80U) printable.pop_back();
    printable.pop_back();
  }
  return printable;
}

Progress::Progress(Host& host)
    : host_(host),
      began_(std::chrono::steady_clock::now()),
      next_(began_ + first_after),
      wanted_(host.shows_progress()) {}

Progress::~Progress() {
  if (wanted_) clear_progress();
}

bool Progress::due() {
  host_.check();
  if (!wanted_) return false;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return false;
  next_ = now + then_every;
  return true;
}

void Progress::show(std::string_view text) {
  // A line that wraps cannot be replaced.
  const std::size_t columns = terminal_columns(STDERR_FILENO);
  write_stderr("\r" + cut_off(text, columns == 0 ? std::string::npos : columns - 1) + "\x1b[K");
  line_shown = true;
}

double Progress::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

std::string rate_text(double per_second, std::string_view unit) {
  if (!(per_second > 0) || !std::isfinite(per_second)) return {};
  constexpr std::array<std::pair<double, std::string_view>, 3> prefixes{
      {{1e9, "G"}, {1e6, "M"}, {1e3, "k"}}};
  for (const auto& [factor, prefix] : prefixes) {
    if (per_second < factor) continue;
    const std::string_view gap = unit.size() > 1 ? " " : "";
    return fmt::format(", {:.2f} {}{}{}/s", per_second / factor, prefix, gap, unit);
  }
  return fmt::format(", {:.1f} {}/s", per_second, unit);
}

std::string left_text(double seconds) {
  constexpr double most = 100.0 * 24 * 3600;
  if (!(seconds >= 0) || seconds > most) return {};
  const auto whole = static_cast<std::uint64_t>(seconds + 0.5);
  if (whole < 3'600) return fmt::format(", {}:{:02} left", whole / 60, whole % 60);
  return fmt::format(", {}:{:02}:{:02} left", whole / 3'600, whole / 60 % 60, whole % 60);
}

std::string progress_text(const ProgressCount& count, std::string_view unit, double seconds) {
  const double rate = static_cast<double>(count.done - count.before) / seconds;
  if (count.all == 0) return fmt::format("{} {}{}", count.done, unit, rate_text(rate, unit));
  return fmt::format("{} of {} {}{}{}", count.done, count.all, unit, rate_text(rate, unit),
                     left_text(static_cast<double>(count.all - count.done) / rate));
}

void clear_progress() {
  if (line_shown.exchange(false)) write_stderr("\r\x1b[K");
}

}  // namespace biss::verbs
