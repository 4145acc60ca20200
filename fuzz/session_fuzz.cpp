// The master's end of the control communication with an encoder that sends any answer. Every access
// ends in bounded time, changes only its own bytes, and begins only when the encoder is idle. The
// next access to a valid encoder succeeds.
//
// Input: up to six accesses. For each access: its kind and the time of execution, slave and
// address, size, retries and the longest delay, the source of CDS after the end of the input. Then
// one byte for each run of frames: bits 0 and 1 the source of CDS (0, 1, missing, a valid encoder),
// bits 2 and 3 the time to the next frame, bit 4 the encoder does not receive a frame without CDS,
// bits 5…7 the number of frames, as a power of two. 0xFF cancels the access.
#include "fuzz/control_end.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

constexpr Picoseconds cycle = microseconds(50);
constexpr std::uint8_t untouched = 0xA5;

enum class Kind : std::uint8_t { read, write, command, broadcast };

struct Access {
  Kind kind = Kind::read;
  ExecuteIf execute_if = ExecuteIf::all_accept;
  std::uint8_t slave = 0;  // of a command: the mask
  std::uint8_t address = 0;
  std::uint8_t size = 0;
  std::uint8_t retries = 0;
  std::uint8_t busy_cycles = 0;
  std::uint8_t afterwards = 0;  // a frame's byte

  bool possible() const {
    if (kind == Kind::broadcast) return true;
    if (kind == Kind::command) return slave != 0;
    return slave < 8 && size >= 1 && size <= 64 && address + size <= 128;
  }
};

Access read_access(ByteSource& bytes) {
  Access access;
  const std::uint8_t kind = bytes.next();
  access.kind = static_cast<Kind>(kind % 4U);
  access.execute_if = static_cast<ExecuteIf>((kind >> 2U) % 3U);
  access.slave = bytes.next();
  // Mostly the existing slave, or its neighbour.
  if (access.kind != Kind::command && access.slave >= 16) access.slave %= 2;
  access.address = bytes.next();
  access.size = bytes.next();
  // Mostly short.
  if (access.size >= 80) access.size = static_cast<std::uint8_t>(1 + access.size % 4U);
  const std::uint8_t options = bytes.next();
  access.retries = options % 4U;
  access.busy_cycles = static_cast<std::uint8_t>((options >> 2U) % 16U);
  access.afterwards = bytes.next();
  return access;
}

/// One try: the frames lost before the start bit, the zeros and the header. For each byte its bits,
/// the longest delay, the frame in which S is first due, and the first frame after the limit.
std::uint32_t most_frames(const Access& access) {
  const std::uint32_t each = 14U + access.busy_cycles + 2U;
  return (1U + access.retries) * (13U + 14U + 25U + each * access.size + 1U);
}

class Line {
 public:
  Line() : server_(OpenRegisters{}) {
    for (std::size_t i = 0; i < registers().size(); ++i) {
      registers()[i] = static_cast<std::uint8_t>(37 * i + 5);
    }
  }

  void attack(ByteSource& bytes);
  void check_good_access();

 private:
  std::array<std::uint8_t, register_count>& registers() { return server_.owner().value; }

  void begin(const Access& access);
  void frame(std::uint8_t byte, const Access& access);
  void check_outcome(const Access& access) const;
  void run_well(std::uint32_t most) {
    run_access(
        session_, now_, most, [&] { return server_.cds(false); },
        [&](bool bit) { server_.cdm(bit); });
    require(!session_.outcome().error && session_.outcome().tries == 1);
  }

  ControlSession session_;
  OpenServer server_;
  Picoseconds now_{};
  std::array<std::uint8_t, 96> buffer_{};
  std::uint32_t frames_ = 0;         // of this access
  std::uint32_t tries_ = 0;          // begun, as seen last
  unsigned owed_ = 0;                // zeros after an error, before the next start bit
  bool start_bit_expected_ = false;  // the next 1 begins a control frame
};

void Line::begin(const Access& access) {
  session_.set_options(
      {.busy_max = std::int64_t{access.busy_cycles} * cycle, .retries = access.retries});
  buffer_.fill(untouched);
  const std::span<std::uint8_t> bytes = std::span(buffer_).first(access.size);
  const auto command = static_cast<ControlCommand>(access.address % 4U);
  switch (access.kind) {
    case Kind::read:
      session_.read(access.slave, access.address, bytes);
      break;
    case Kind::write:
      session_.write(access.slave, access.address, bytes);
      break;
    case Kind::command:
      session_.command(access.slave, command, access.execute_if);
      break;
    case Kind::broadcast:
      session_.broadcast(command);
      break;
  }
  frames_ = 0;
  tries_ = 1;
  start_bit_expected_ = true;
  require(session_.done() == !access.possible());
  require(access.possible() || session_.outcome().error == ControlError::bad_request);
}

void Line::frame(std::uint8_t byte, const Access& access) {
  constexpr unsigned missing = 2;
  constexpr unsigned good = 3;
  const bool running = !session_.done();
  const unsigned what = byte % 4U;
  const bool answer = server_.cds(false);
  CdsBit cds = (what == good ? answer : what == 1) ? CdsBit::one : CdsBit::zero;
  if (what == missing) cds = CdsBit::missing;
  now_ += std::int64_t{1 + (byte >> 2U) % 4U} * cycle;
  const bool cdm = session_.step(now_, cds);
  require(running || !cdm);
  if (running) ++frames_;
  const bool retried = session_.outcome().tries != tries_;
  if (retried) {
    require(session_.outcome().retried.has_value() && !cdm);
    tries_ = session_.outcome().tries;
    start_bit_expected_ = true;
  }
  if (retried || (running && session_.done() && session_.outcome().error)) {
    owed_ = biss::control_reset_zeros;
  }
  if (cdm && start_bit_expected_) {
    require(server_.idle() && owed_ == 0);
    start_bit_expected_ = false;
  }
  const bool counts = cds != CdsBit::missing || access.kind == Kind::broadcast;
  if (owed_ != 0 && !cdm && counts) --owed_;
  // A frame without CDS may not have been received; a frame of a broadcast is received.
  const bool heard = cds != CdsBit::missing || (byte & 16U) == 0;
  if (heard || (running && access.kind == Kind::broadcast)) server_.cdm(cdm);
}

void Line::check_outcome(const Access& access) const {
  const ControlOutcome& outcome = session_.outcome();
  const bool registers = access.kind == Kind::read || access.kind == Kind::write;
  require(outcome.frames == frames_);
  require(outcome.tries <= 1U + access.retries);
  require((outcome.tries > 1) == outcome.retried.has_value());
  require(!outcome.retried || worth_retrying(*outcome.retried));
  require(outcome.bytes_done <= (registers ? access.size : 0));
  if (!outcome.error) {
    require(!registers || outcome.bytes_done == access.size);
    require(access.kind == Kind::broadcast || outcome.slaves_present != 0);
  }
  // The IDs taken have no gap.
  require((outcome.slaves_present & (outcome.slaves_present + 1U)) == 0);
  require(!outcome.more_slaves || outcome.slaves_present == 0xFF);
  // S in the first frame after the limit is still accepted.
  require(outcome.longest_busy <= std::int64_t{access.busy_cycles + 4} * cycle);
  require(access.busy_cycles != 0 || outcome.longest_busy == Picoseconds{});
  const std::size_t written = access.kind == Kind::read ? outcome.bytes_done : 0U;
  require(std::all_of(buffer_.begin() + static_cast<std::ptrdiff_t>(written), buffer_.end(),
                      [](std::uint8_t byte) { return byte == untouched; }));
}

void Line::attack(ByteSource& bytes) {
  const Access access = read_access(bytes);
  begin(access);
  const std::uint32_t most = most_frames(access);
  bool cancelled = false;
  while (!bytes.done() && !session_.done()) {
    const std::uint8_t byte = bytes.next();
    if (byte == 0xFF) {
      session_.cancel();
      owed_ = biss::control_reset_zeros;
      cancelled = true;
      break;
    }
    // Steps after the end are idle frames.
    for (unsigned i = 0; i < 1U << (byte >> 5U); ++i) {
      frame(byte, access);
      require(frames_ <= most);
    }
  }
  while (!session_.done()) {
    frame(access.afterwards, access);
    require(frames_ <= most);
  }
  require(!cancelled || session_.outcome().error == ControlError::cancelled);
  check_outcome(access);
}

// This access succeeds immediately after any sequence: the session knows how many zeros are still
// due.
void Line::check_good_access() {
  session_.set_options({.busy_max = Picoseconds{}});
  if (!server_.control_active(0)) {
    session_.broadcast(ControlCommand::control);
    run_well(broadcast_command_frames);
    require(server_.control_active(0));
  }
  std::array<std::uint8_t, 3> bytes{};
  session_.read(0, 0x20, bytes);
  run_well(register_access_frames(bytes.size()));
  require(std::equal(bytes.begin(), bytes.end(), registers().begin() + 0x20));
  const std::array<std::uint8_t, 2> written{0x5A, static_cast<std::uint8_t>(~bytes[1])};
  session_.write(0, 0x21, written);
  run_well(register_access_frames(written.size()));
  require(registers()[0x20] == bytes[0] && registers()[0x21] == written[0] &&
          registers()[0x22] == written[1]);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  Line line;
  for (int i = 0; i < 6 && !bytes.done(); ++i) line.attack(bytes);
  line.check_good_access();
  return 0;
}
