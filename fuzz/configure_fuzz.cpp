// Configuration against encoders with changed answers or wrong data. Configuration always ends, its
// result is possible, and it reports every state that it did not restore.
//
// Input: options and the number of devices. For each device 8 bytes (struct Device) and the changes
// of its banks. One byte for the answers after the end of the input. Then one byte for each run of
// frames: bits 0 and 1 the source of CDS (0, 1, missing, the encoders), bit 2 the encoders do not
// receive a frame without CDS, bits 3…6 the number of frames, as a power of two.
#include "biss/configure/configurator.hpp"
#include "biss/control/register_map.hpp"
#include "biss/frame/format_text.hpp"
#include "biss/slave/register_server.hpp"
#include "fuzz/register_seeds.hpp"
#include "fuzz/target.hpp"

namespace {

using namespace biss;
using namespace biss::fuzz;

constexpr std::uint8_t eds_bank = 1;
constexpr std::size_t device_banks = 5;

using Banks = std::array<EdsBank, device_banks>;

/// Valid data sheets, from bank 1 on.
const std::array<Banks, 16>& good_sheets() {
  static const std::array<Banks, 16> sheets = [] {
    std::array<Banks, 16> made{};
    for (std::size_t i = 0; i < made.size(); ++i) {
      const auto banks = eds_banks_seed(i, eds_bank);
      std::copy(banks.begin(), banks.end(), made[i].begin() + eds_bank);
    }
    return made;
  }();
  return sheets;
}

/// One encoder of one slave: registers, BSEL, whether it sends its channel.
struct Device {
  Banks banks{};
  std::array<std::uint8_t, bank_bytes> direct{};
  std::uint8_t absent = 0;  // of the fields of the map, bit k: number k + 1
  std::uint8_t bsel = 0;
  std::uint8_t bsel_at_first = 0;
  std::uint8_t busy_frames = 0;
  bool w_inversion = true;
  bool bsel_writable = true;
  bool knows_channels = true;
  bool channels = true;

  bool permits(RegisterAccess access, std::uint8_t address) const {
    if (address == reg::bsel) return access == RegisterAccess::read || bsel_writable;
    if (access == RegisterAccess::write) return false;
    if (address < reg::bsel) return bsel < device_banks;
    for (std::size_t k = 2; k < register_fields.size(); ++k) {
      if (register_fields[k].contains(address)) return (absent >> (k - 2) & 1U) == 0;
    }
    return false;
  }
  std::uint8_t value(std::uint8_t address) const {
    if (address == reg::bsel) return bsel;
    return address < reg::bsel ? banks[bsel][address] : direct[address - reg::bsel];
  }
};

struct Owner {
  Device* device = nullptr;

  bool permits(unsigned, RegisterAccess access, std::uint8_t address) const {
    return device->permits(access, address);
  }
  std::optional<std::uint8_t> read(unsigned, std::uint8_t address) const {
    return device->value(address);
  }
  bool ready(unsigned) const { return true; }
  void write(unsigned, std::uint8_t address, std::uint8_t value) const {
    require(address == reg::bsel);
    device->bsel = value;
  }
  bool accepts(unsigned, ControlCommand command, bool) const {
    return command == ControlCommand::channels && device->knows_channels;
  }
  void execute(unsigned, ControlCommand, bool broadcast) const { device->channels = !broadcast; }
};

using Server = RegisterServer<Owner>;

Device read_device(ByteSource& bytes) {
  Device device;
  const std::uint8_t flags = bytes.next();
  device.banks = good_sheets()[bytes.next() % good_sheets().size()];
  device.absent = bytes.next();
  device.bsel_writable = (flags & 1U) == 0;
  device.knows_channels = (flags & 2U) == 0;
  device.w_inversion = (flags & 4U) == 0;
  device.busy_frames = (flags & 8U) != 0 ? 1 : 0;
  device.bsel = device.bsel_at_first = (flags & 16U) != 0 ? bytes.next() : std::uint8_t{0};
  device.direct[1] = (flags & 32U) != 0 ? bytes.next() : eds_bank;
  // The profile of the first channel, or any profile.
  device.direct[2] = device.banks[2][2];
  device.direct[3] = device.banks[2][3];
  const std::size_t changes = flags >> 6U;
  for (std::size_t i = 0; i < changes * 2; ++i) {
    const std::size_t at = bytes.next_16() % ((device_banks + 1) * bank_bytes);
    const std::uint8_t value = bytes.next();
    if (at / bank_bytes < device_banks) {
      device.banks[at / bank_bytes][at % bank_bytes] = value;
    } else {
      device.direct[at % bank_bytes] = value;
    }
  }
  if (changes % 2 == 0) {
    for (EdsBank& bank : device.banks) bank = sealed(bank);
  }
  return device;
}

class Line {
 public:
  explicit Line(ByteSource& bytes);
  void run(ByteSource& bytes);
  void check() const;

 private:
  void request(std::uint8_t how);
  void check_told() const;
  void check_honest() const;

  ConfigureOptions options_{};
  std::vector<Device> devices_{};
  std::vector<Server> servers_{};
  std::uint8_t afterwards_ = 0;
  std::optional<Configurator> configurator_{};
  Picoseconds now_{};
  std::uint32_t requests_ = 0;
  bool false_answers_ = false;
  bool lost_answers_ = false;
};

Line::Line(ByteSource& bytes) {
  const std::uint8_t flags = bytes.next();
  constexpr std::array<std::uint32_t, 4> bounds{100'000, 10'000, 2'000, 100};
  options_.max_requests = bounds[flags % 4U];
  options_.switch_channels = (flags & 4U) == 0;
  options_.control.retries = (flags >> 3U) % 4U;
  // Mostly one device, rarely more than there are IDs.
  constexpr std::array<std::uint8_t, 8> counts{1, 1, 1, 2, 0, 3, 2, 10};
  devices_.resize(counts[flags >> 5U]);
  for (Device& device : devices_) device = read_device(bytes);
  for (Device& device : devices_) {
    servers_.emplace_back(Owner{&device}, RegisterServerOptions{.w_inversion = device.w_inversion,
                                                                .busy_frames = device.busy_frames});
  }
  afterwards_ = bytes.next();
  configurator_.emplace(options_);
}

void Line::request(std::uint8_t how) {
  const bool reduced = configurator_->request().kind == RequestKind::reduced;
  const unsigned what = how % 4U;
  const bool missing = what == 2;
  const bool heard = !missing || (how & 4U) == 0;
  bool answer = false;
  if (heard && !reduced) {
    for (Server& server : servers_) answer = server.cds(answer);
  }
  CdsBit cds = answer ? CdsBit::one : CdsBit::zero;
  if (what < 2) cds = what == 1 ? CdsBit::one : CdsBit::zero;
  false_answers_ = false_answers_ || (!reduced && what < 2 && answer != (what == 1));
  lost_answers_ = lost_answers_ || missing;
  if (missing || reduced || servers_.empty()) cds = CdsBit::missing;
  now_ = std::max(now_, configurator_->request().at);
  const bool cdm = configurator_->answer(now_, cds);
  if (heard) {
    for (Server& server : servers_) server.cdm(cdm);
  }
  ++requests_;
  require(configurator_->requests() == requests_ && requests_ <= options_.max_requests);
}

void Line::run(ByteSource& bytes) {
  while (!configurator_->done()) {
    const std::uint8_t how = bytes.done() ? afterwards_ : bytes.next();
    for (unsigned i = 0; i < 1U << (how >> 3U) % 16U && !configurator_->done(); ++i) request(how);
  }
}

void check_configuration(const Configuration& config) {
  require(config.slave_count >= 1 && config.slave_count <= control_max_slaves);
  require(config.format.channel_count >= 1 && config.format.channel_count <= config.slave_count);
  const auto text = format_text(config.format);
  const auto again = parse_format(text.view());
  require(again.ok() && *again == config.format);
  const DeviceTiming& timing = config.timing;
  require(timing.clock_min.count > 0 && timing.clock_min <= timing.clock_max &&
          timing.clock_max <= biss_clock_max);
  require(timing.ack_max.count > 0 && timing.ack_max <= biss_busy_max);
  require(timing.timeout.time.count > 0 && timing.cycle_min.count >= 0);
  require(config.start_delay_clocks <= biss_busy_s_max_clocks + config.slave_count - 1);
  const auto setup = config.master_setup(period_of(timing.clock_max));
  const auto bounds = request_ack_bounds(with_defaults(setup));
  require(bounds.min_clocks >= 1 && bounds.min_clocks <= bounds.max_clocks);
}

void check_fault(const ConfigureFault& fault) {
  require(static_cast<std::size_t>(fault.cause) < configure_error_count);
  require(fault.step < ConfigureStep::done && fault.slave < control_max_slaves);
  require((fault.cause == ConfigureError::unknown_profile) == fault.profile.has_value());
}

// Every state that was not restored is reported, also after lost answers.
void Line::check_told() const {
  const Unrestored left = configurator_->unrestored();
  for (std::size_t k = 0; k < devices_.size(); ++k) {
    const Device& device = devices_[k];
    require(device.bsel == device.bsel_at_first || (left.banks >> k & 1U) != 0);
    require(device.channels || left.channels_off);
  }
}

void Line::check_honest() const {
  const auto result = configurator_->result();
  const ConfigureError cause = result.ok() ? ConfigureError{} : result.error().cause;
  if (devices_.empty()) {
    require(cause == ConfigureError::no_encoder);
    return;
  }
  require(!result.ok() || result->slave_count == devices_.size());
  require(cause != ConfigureError::line_lost && cause != ConfigureError::no_control &&
          cause != ConfigureError::control_failed && cause != ConfigureError::channels_stay_off);
  require(result.ok() || cause != ConfigureError::no_encoder);
  const Unrestored left = configurator_->unrestored();
  require(left.banks == 0 && (!left.channels_off || devices_.size() > control_max_slaves));
  for (const Server& server : servers_) require(server.idle());
}

void Line::check() const {
  const auto result = configurator_->result();
  result.ok() ? check_configuration(*result) : check_fault(result.error());
  if (!false_answers_) check_told();
  const bool cut = !result.ok() && result.error().cause == ConfigureError::too_many_requests;
  const bool stopped = configurator_->requests() == options_.max_requests;
  if (!false_answers_ && !lost_answers_ && !cut && !stopped) check_honest();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ByteSource bytes(data, size);
  Line line(bytes);
  line.run(bytes);
  line.check();
  return 0;
}
