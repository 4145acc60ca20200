// Our encoder answers a master in Verilog: Verilator runs the master, the C interface the encoder,
// this loop the time and the line between them.
#include <Vbiss_line_master.h>
#include <biss_c.h>
#include <verilated.h>

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <memory>
#include <utility>

namespace {

constexpr const char* encoder = "pos26,nE,nW,crc6;cds0";
constexpr std::int64_t half_clock_ps = 6'250;  // clk at 80 MHz, so MA at 5 MHz
constexpr std::int64_t line_delay_ps = 333'000;
// MA to STOP and the longest timeout, and a lot more.
constexpr int clocks_max = 100'000;

// The causes of the master that occur here, and the names of all of them.
constexpr unsigned ok = 0;
constexpr unsigned no_response = 1;
constexpr unsigned crc = 5;
constexpr const char* causes[] = {"ok",  "no_response", "response_range", "no_start",
                                  "cds", "crc",         "stop_bit"};

/// The values that the encoder sends in a request, and the cause that the master finds: the cable
/// is cut for no_response, and a bit is flipped for crc.
struct Request {
  const char* what;
  std::uint64_t position;
  bool nE;
  bool nW;
  unsigned cause;
};

constexpr Request requests[] = {
    {"position 0", 0, true, true, ok},
    {"a position", 12'345'678, true, true, ok},
    {"the last position", (1U << 26U) - 1U, true, true, ok},
    {"error flag", 4'711, false, true, ok},
    {"warning flag", 4'712, true, false, ok},
    {"a bit flipped", 12'345'678, true, true, crc},
    {"cable cut", 12'345'678, true, true, no_response},
    {"connected again", 42, true, true, ok},
};

void sample(void* user, std::int64_t, biss_channel* channels, std::size_t) {
  const auto& request = **static_cast<const Request**>(user);
  channels[0].position = request.position;
  channels[0].nE = request.nE;
  channels[0].nW = request.nW;
}

/// SLO on its way to the master.
class Cable {
 public:
  void put(std::int64_t now, bool level) {
    if (level != sent_) changes_.emplace_back(now + line_delay_ps, level);
    sent_ = level;
  }
  bool level_at(std::int64_t now) {
    for (; !changes_.empty() && changes_.front().first <= now; changes_.pop_front()) {
      received_ = changes_.front().second;
    }
    return received_;
  }

 private:
  std::deque<std::pair<std::int64_t, bool>> changes_;
  bool sent_ = true;
  bool received_ = true;
};

class Bench {
 public:
  Bench() {
    biss_format format = biss_format_defaults();
    biss_status status = biss_format_parse(encoder, &format);
    format.timing.timeout.rule = BISS_TIMEOUT_FIXED;
    format.timing.timeout.time_ps = 20'000'000;
    biss_slave_setup setup = biss_slave_defaults(&format);
    setup.sample = &sample;
    setup.user = &request_;
    if (status == BISS_OK) status = biss_slave_init(&slave_, &setup);
    if (status != BISS_OK) std::fprintf(stderr, "%s\n", biss_status_text(status));
    master_->reset = 1;
    for (int i = 0; i < 8; ++i) clock();
    master_->reset = 0;
  }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  bool opened() const { return biss_slave_state(&slave_) != nullptr; }

  /// One request; false if the outputs of the master are wrong.
  bool run(const Request& request) {
    request_ = &request;
    for (int i = 0; i < clocks_max && !master_->ready; ++i) clock();
    master_->start = 1;
    clock();
    master_->start = 0;
    const std::int64_t begin = now_;
    for (int i = 0; i < clocks_max && !master_->valid; ++i) {
      // The frame takes 40 periods of 200 ns: this is somewhere in the data.
      flipped_ = request.cause == crc && now_ - begin > 3'000'000 && now_ - begin <= 3'200'000;
      clock();
    }
    flipped_ = false;
    return show(request);
  }

 private:
  bool connected() const { return request_->cause != no_response; }

  // One clock of the master: both edges of clk, the encoder between them.
  void clock() {
    for (const int level : {1, 0}) {
      now_ += half_clock_ps;
      while (answer_.deadline_ps <= now_) step(answer_.deadline_ps);
      master_->slo = !connected() || (slo_.level_at(now_) != flipped_);
      master_->clk = static_cast<std::uint8_t>(level);
      master_->eval();
      if (static_cast<bool>(master_->ma) != ma_) {
        ma_ = master_->ma;
        step(now_);
      }
    }
  }

  void step(std::int64_t now) {
    const bool seen = ma_ || !connected();
    const biss_status status = biss_slave_step(&slave_, now, seen, false, &answer_);
    if (status != BISS_OK) std::fprintf(stderr, "%s\n", biss_status_text(status));
    slo_.put(now, answer_.level);
  }

  bool show(const Request& request) const {
    std::printf("%8.2f us  %-18s", static_cast<double>(now_) / 1e6, request.what);
    if (!master_->valid) {
      std::puts("the master hangs");
      return false;
    }
    std::printf("%-11s  position %8" PRIu32 "  nE %d  nW %d\n", causes[master_->cause],
                master_->position, master_->nE, master_->nW);
    if (request.cause != master_->cause) return false;
    return master_->cause != ok ||
           (master_->position == request.position && static_cast<bool>(master_->nE) == request.nE &&
            static_cast<bool>(master_->nW) == request.nW);
  }

  std::unique_ptr<Vbiss_line_master> master_ = std::make_unique<Vbiss_line_master>();
  biss_slave slave_{};
  biss_output answer_{true, BISS_NEVER};
  Cable slo_;
  const Request* request_ = &requests[0];
  std::int64_t now_ = 0;
  bool ma_ = true;
  bool flipped_ = false;
};

}  // namespace

int main() {
  Bench bench;
  if (!bench.opened()) return 1;
  bool good = true;
  for (const Request& request : requests) good = bench.run(request) && good;
  std::puts(good ? "all as expected" : "not as expected");
  return good ? 0 : 1;
}
