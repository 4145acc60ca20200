// The screen of `biss read --live`.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "device/quantity.hpp"
#include "live/line_reader.hpp"
#include "live/live_axis.hpp"
#include "report/summary.hpp"
#include "rows/motion.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/terminal.hpp"

namespace biss::cli {

/// The whole terminal, whose content is replaced. Nothing waits for a slow one.
class Screen {
 public:
  Screen() {
    // A separate opening: the standard streams of other programs wait as before.
    const char* const name = ::ttyname(STDOUT_FILENO);
    terminal_ = ::open(name, O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (terminal_ < 0 || ::tcgetattr(terminal_, &before_) != 0) {
      throw verbs::wrong_file("the terminal: {}", std::strerror(errno));
    }
    termios keys = before_;
    keys.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    keys.c_iflag &= ~static_cast<tcflag_t>(IXON);
    // A program that stops would leave the screen as it is.
    keys.c_cc[VSUSP] = keys.c_cc[VQUIT] = _POSIX_VDISABLE;
    ::tcsetattr(terminal_, TCSANOW, &keys);
  }
  ~Screen() { restore(); }
  Screen(const Screen&) = delete;
  Screen& operator=(const Screen&) = delete;

  /// Gives the terminal back as it was. A signal handler may call it.
  static void restore() {
    const int terminal = terminal_.exchange(-1);
    pollfd ready{terminal, POLLOUT, 0};
    // CAN ends a sequence that was cut off.
    std::string_view text = "\x18\x1b[?7h\x1b[?25h\x1b[?1049l";
    while (terminal >= 0 && !text.empty()) {
      const auto sent = ::write(terminal, text.data(), text.size());
      if (sent > 0) text.remove_prefix(static_cast<std::size_t>(sent));
      const bool waits = sent > 0 || errno == EINTR || errno == EAGAIN;
      if (!waits || ::poll(&ready, 1, 1'000) == 0) break;
    }
    if (terminal < 0) return;
    ::tcflush(terminal, TCIFLUSH);
    ::tcsetattr(terminal, TCSANOW, &before_);
    ::close(terminal);
  }

  /// A key that was pressed; 0: none.
  static char key() {
    char key = '\0';
    return ::read(terminal_, &key, 1) == 1 ? key : '\0';
  }

  /// Lines and columns that do not fit are cut off. The content is not shown if the terminal has not
  /// taken the content before yet.
  void show(std::string_view lines) {
    winsize size{};
    ::ioctl(terminal_, TIOCGWINSZ, &size);
    std::string text = "\x1b[H";
    for (int row = 0; !lines.empty() && row < (size.ws_row == 0 ? 24 : size.ws_row); ++row) {
      const std::string_view line = lines.substr(0, lines.find('\n'));
      lines.remove_prefix(std::min(line.size() + 1, lines.size()));
      text += row == 0 ? "" : "\r\n";
      text += verbs::cut_off(line, size.ws_col == 0 ? 80 : size.ws_col) + "\x1b[K";
    }
    if (unsent_.empty() || unsent_ == enter) unsent_ += text + "\x1b[J";
    const auto sent = ::write(terminal_, unsent_.data(), unsent_.size());
    if (sent > 0) unsent_.erase(0, static_cast<std::size_t>(sent));
  }

 private:
  // A second screen without the lines above, no cursor, no line breaks.
  static constexpr std::string_view enter = "\x1b[?1049h\x1b[?25l\x1b[?7l";
  static inline std::atomic<int> terminal_ = -1;
  static inline termios before_{};
  std::string unsent_{enter};
};

inline std::string failed_transfers(const live::ReadCounts& counts) {
  std::string text;
  for (std::size_t k = 0; k < live::port_fault_count; ++k) {
    report::append_count(text, counts.faults[k], name_of(static_cast<live::PortFault>(k)));
  }
  return text.empty() ? "none" : text;
}

/// The facts that do not change while a line is shown.
struct LiveSetup {
  struct Channel {
    unsigned position_bits = 0;
    std::vector<rows::Scale> units;
  };
  std::string title;
  Hertz rate{};
  std::vector<Channel> channels;
};

/// The host of a run whose line is shown: rows are not written, messages are printed at the end.
class LiveView final : public verbs::MemoryHost {
 public:
  /// \param begin called before the first row, when the format is known
  LiveView(verbs::Host& outer, std::function<LiveSetup()> begin)
      : verbs::MemoryHost(&outer), outer_(outer), begin_(std::move(begin)) {}
  ~LiveView() override {
    screen_.reset();
    outer_.print_summary(text());
  }

  std::unique_ptr<report::TableWriter> keep_rows(std::span<const report::Column>) override {
    struct NoRows final : report::TableWriter {
      bool row(std::span<const report::Cell>) override { return true; }
      bool finish() override { return true; }
    };
    setup_ = begin_();
    screen_.emplace();
    return std::make_unique<NoRows>();
  }

  /// Draws ten times a second.
  /// \param axis null before the first row
  /// \return a key for the caller; 0: none
  char tick(const live::LiveAxis* axis, const live::ReadCounts& counts, std::string_view record) {
    const auto now = Clock::now();
    if (!screen_ || now < next_) return '\0';
    next_ = now + std::chrono::milliseconds(100);
    const double seconds = std::chrono::duration<double>(now - second_).count();
    new_second_ = seconds >= 1;
    if (new_second_) seconds_ = second_ == Clock::time_point{} ? 0 : seconds;
    if (new_second_) second_ = now;
    // All keys that have come; one of a kind counts.
    std::string keys;
    for (char key = Screen::key(); key != '\0' && keys.size() < 4096; key = Screen::key())
      keys += key;
    const auto pressed = [&keys](char key) { return keys.find(key) != std::string::npos; };
    if (pressed('u')) ++unit_;
    report::Summary text;
    text.title(setup_.title);
    for (std::size_t k = 0; k < axis->axes(); ++k) {
      if (pressed('z')) shown_[k].zero = axis->position(k).position;
      if (axis->axes() > 1) text.title(fmt::format("channel {}", k + 1));
      add_channel(text, *axis, k);
    }
    text.title("line");
    add_line(text, *axis, counts);
    text.entry("record", record.empty() ? "off" : record);
    if (!lines().empty()) text.entry("message", lines().back());
    text.title("z zero  u unit  r record  q end");
    screen_->show(text.text());
    return pressed('q') ? 'q' : pressed('r') ? 'r' : '\0';
  }

 private:
  using Clock = std::chrono::steady_clock;

  // In the last whole second. Each number has a place of its own.
  std::string rate(std::size_t place, std::uint64_t number) {
    auto& [older, newer] = numbers_[place];
    if (new_second_) older = std::exchange(newer, number);
    return seconds_ == 0 ? ""
                         : fmt::format("{:.1f}/s", static_cast<double>(newer - older) / seconds_);
  }

  void add_channel(report::Summary& text, const live::LiveAxis& axis, std::size_t k) {
    const LiveSetup::Channel& channel = setup_.channels[k];
    const auto& [per_count, unit] = channel.units[unit_ % channel.units.size()];
    const AxisPosition now = axis.position(k);
    Shown& shown = shown_[k];
    const bool known = now.number != 0;
    const std::int64_t counts = now.position - shown.zero.value_or(0);
    const std::string position =
        unit == "counts" ? fmt::format("{} counts", counts)
                         : fmt::format("{:.6f} {}", static_cast<double>(counts) * per_count, unit);
    text.entry("position", known ? position : "-", shown.zero ? "from the zero set here" : "");
    text.entry("turns", known ? fmt::format("{}", now.position >> channel.position_bits) : "-");
    // Two positions have a distance if the axis did not start again in between.
    const std::uint32_t starts = axis.count(k, AxisCause::first);
    const double seconds = static_cast<double>((now.moment - shown.last.moment).count) / 1e12;
    const bool moved = shown.last.number != 0 && starts == shown.starts && seconds > 0;
    const auto step = static_cast<double>(now.position - shown.last.position);
    text.entry("velocity",
               moved ? fmt::format("{:.3f} {}/s", step * per_count / seconds, unit) : "-");
    shown = {shown.zero, now, starts};
    text.entry("state", name_of(now.state), name_of(now.cause));
    if (const auto& frame = axis.frame()) {
      const Channel& sent = frame->channel_list[k];
      text.entry("sent", fmt::format("{}", sent.position),
                 fmt::format("nE = {:d}, nW = {:d}", sent.nE, sent.nW));
    }
    for (std::size_t i = 0; i < axis_cause_count; ++i) {
      const std::uint32_t count = axis.count(k, static_cast<AxisCause>(i));
      const std::string per_second = rate(k * axis_cause_count + i, count);
      if (count == 0) continue;
      text.entry(name_of(static_cast<AxisCause>(i)), fmt::format("{}", count), per_second);
    }
  }

  void add_line(report::Summary& text, const live::LiveAxis& axis, const live::ReadCounts& counts) {
    text.entry("requests", fmt::format("{}", counts.requests),
               rate(numbers_.size() - 1, counts.requests) + "  " + text_of(setup_.rate) + " asked");
    text.entry("late", fmt::format("{} not made", counts.late));
    text.entry("failed", failed_transfers(counts));
    const auto& frame = axis.frame();
    const auto seen = axis.line_delay_seen();
    if (!frame || !seen) return;
    const std::uint16_t delay = line_delay_clocks(*frame);
    if (!first_delay_) first_delay_ = delay;
    text.entry("line delay", report::counted(delay, "clock") + " of MA",
               fmt::format("{:+d} since the start, {} to {} seen", delay - *first_delay_,
                           seen->first, seen->second));
    text.entry("ACK", report::counted(frame->ack_clocks, "clock"));
  }

  struct Shown {
    std::optional<std::int64_t> zero;
    AxisPosition last{};
    std::uint32_t starts = 0;
  };

  verbs::Host& outer_;
  std::function<LiveSetup()> begin_;
  LiveSetup setup_;
  std::optional<Screen> screen_;
  Clock::time_point next_{};
  // The begin of the second that runs, and the length of the one before.
  Clock::time_point second_{};
  double seconds_ = 0;
  bool new_second_ = false;
  std::array<std::pair<std::uint64_t, std::uint64_t>, max_channels * axis_cause_count + 1>
      numbers_{};
  std::array<Shown, max_channels> shown_{};
  std::size_t unit_ = 1;
  std::optional<std::uint16_t> first_delay_;
};

}  // namespace biss::cli
