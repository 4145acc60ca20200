// biss_control: the core's ControlSession, and the query of one device.
#include "capi/control.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

namespace biss::capi {

namespace {

static_assert(BISS_COMMAND_USER == static_cast<int>(ControlCommand::user));
static_assert(BISS_EXECUTE_ALWAYS == static_cast<int>(ExecuteIf::always));
static_assert(BISS_CDS_MISSING == static_cast<int>(CdsBit::missing));

// Whether an access can begin; then nothing is read yet.
biss_status begin(biss_control* control, bool is_possible = true) {
  if (const auto wrong = check_call(control)) return wrong;
  if (!is_possible) return BISS_BAD_SETUP;
  Control& self = thing<Control>(control);
  if (!self.done()) return BISS_RUNNING;
  self.read_count = 0;
  self.queried = false;
  self.earlier_frames = self.earlier_tries = 0;
  self.earlier_busy = {};
  return BISS_OK;
}

bool is_command(biss_command command) {
  return command >= BISS_COMMAND_CHANNELS && command <= BISS_COMMAND_USER;
}

const char* error_of(const Control& control) {
  auto error = control.session.outcome().error;
  if (control.queried) error = control.query.failed();
  return error ? name_of(*error).data() : nullptr;
}

void put_eds(const EdsImage& image, biss_device& device) {
  device.has_common = true;
  std::copy(image.common->begin(), image.common->end(), device.common);
  for (std::size_t i = 0; i < max_channels; ++i) {
    if (image.profiles[i] == nullptr) continue;
    device.has_channel[i] = true;
    std::copy(image.profiles[i]->begin(), image.profiles[i]->end(), device.channel[i]);
  }
}

biss_device device_of(const configure_detail::SlaveQuery& query) {
  const SlaveDescription& found = query.description();
  biss_device device{};
  device.has_identity = found.identity.has_value();
  if (found.identity) {
    device.device_id = found.identity->device;
    device.manufacturer = found.identity->manufacturer;
  }
  device.has_serial = found.serial.has_value();
  device.serial = found.serial.value_or(0);
  device.has_profile = found.profile.has_value();
  device.profile = found.profile.value_or(0);
  device.eds_bank = found.eds_bank;
  device.eds_unused = found.eds_unused;
  device.bank_changed = query.bank_dirty();
  if (query.has_eds()) put_eds(query.image(), device);
  return device;
}

}  // namespace

extern "C" {

biss_control_setup biss_control_defaults(void) { return {ControlOptions{}.busy_max.count, 0}; }

biss_status biss_control_init(biss_control* control, const biss_control_setup* setup) {
  if (const auto wrong = begin_init(control)) return wrong;
  const biss_control_setup chosen = setup == nullptr ? biss_control_defaults() : *setup;
  constexpr std::uint32_t most = std::numeric_limits<std::uint8_t>::max();
  if (!is_duration(chosen.busy_max_ps) || chosen.retries > most) return BISS_BAD_SETUP;
  return make<Control>(control,
                       ControlOptions{.busy_max = picoseconds(chosen.busy_max_ps),
                                      .retries = static_cast<std::uint8_t>(chosen.retries)});
}

biss_status biss_control_read(biss_control* control, uint32_t id, uint32_t address, size_t count) {
  if (const auto wrong = begin(control)) return wrong;
  // A request for more registers than fit becomes an impossible request: bad_request.
  auto& self = thing<Control>(control);
  const bool fits = count <= self.bytes.size();
  self.read_count = fits ? count : 0;
  self.session.read(fits ? id : control_max_slaves, address,
                    std::span(self.bytes).first(self.read_count));
  return BISS_OK;
}

biss_status biss_control_write(biss_control* control, uint32_t id, uint32_t address,
                               const uint8_t* bytes, size_t count) {
  if (control != nullptr && bytes == nullptr) return BISS_NULL_ARGUMENT;
  if (count > sequential_max_bytes) return BISS_NO_ROOM;
  if (const auto wrong = begin(control)) return wrong;
  auto& self = thing<Control>(control);
  std::copy_n(bytes, count, self.bytes.begin());
  self.session.write(id, address, std::span(self.bytes).first(count));
  return BISS_OK;
}

biss_status biss_control_command(biss_control* control, uint32_t ids, biss_command command,
                                 biss_execute execute) {
  const bool is_possible = ids <= 0xFFU && is_command(command) &&
                           execute >= BISS_EXECUTE_ALL_ACCEPT && execute <= BISS_EXECUTE_ALWAYS;
  if (const auto wrong = begin(control, is_possible)) return wrong;
  thing<Control>(control).session.command(static_cast<std::uint8_t>(ids),
                                          static_cast<ControlCommand>(command),
                                          static_cast<ExecuteIf>(execute));
  return BISS_OK;
}

biss_status biss_control_broadcast(biss_control* control, biss_command command) {
  if (const auto wrong = begin(control, is_command(command))) return wrong;
  thing<Control>(control).session.broadcast(static_cast<ControlCommand>(command));
  return BISS_OK;
}

biss_status biss_control_cancel(biss_control* control) {
  if (const auto wrong = check_call(control)) return wrong;
  auto& self = thing<Control>(control);
  self.session.cancel();
  while (self.next != nullptr && self.session.done()) {
    self.next(self);
    self.session.cancel();
  }
  return BISS_OK;
}

biss_status biss_control_step(biss_control* control, int64_t now_ps, biss_cds cds, bool* cdm) {
  if (const auto wrong = check_call(control, cdm)) return wrong;
  if (cds < BISS_CDS_ZERO || cds > BISS_CDS_MISSING) return BISS_BAD_SETUP;
  auto& self = thing<Control>(control);
  if (const auto wrong = self.clock.check(now_ps)) return wrong;
  self.clock.set(now_ps);
  *cdm = self.step(self, picoseconds(now_ps), static_cast<CdsBit>(cds));
  return BISS_OK;
}

bool biss_control_done(const biss_control* control) {
  return !is_open(control) || thing<Control>(control).done();
}

biss_status biss_control_outcome_of(const biss_control* control, biss_control_outcome* outcome) {
  if (const auto wrong = check_call(control, outcome)) return wrong;
  auto& self = thing<Control>(control);
  const ControlOutcome& from = self.session.outcome();
  *outcome = {.error = error_of(self),
              .bytes_done = from.bytes_done,
              .devices_present = from.slaves_present,
              .accepted = from.accepted,
              .frames = self.earlier_frames + from.frames,
              .tries = self.earlier_tries + from.tries,
              .longest_busy_ps = std::max(self.earlier_busy, from.longest_busy).count};
  return BISS_OK;
}

biss_status biss_control_bytes(const biss_control* control, uint8_t* bytes, size_t room,
                               size_t* count) {
  if (const auto wrong = check_call(control, bytes, count)) return wrong;
  auto& self = thing<Control>(control);
  *count = std::min<std::size_t>(self.read_count, self.session.outcome().bytes_done);
  if (*count > room) return BISS_NO_ROOM;
  std::copy_n(self.bytes.begin(), *count, bytes);
  return BISS_OK;
}

biss_status biss_control_query(biss_control* control, uint32_t id) {
  if (const auto wrong = begin(control, id < control_max_slaves)) return wrong;
  auto& self = thing<Control>(control);
  self.id = static_cast<std::uint8_t>(id);
  self.query.begin(self.session, self.id);
  self.next = &Control::advance;
  self.queried = true;
  return BISS_OK;
}

biss_status biss_control_device(const biss_control* control, biss_device* device) {
  if (const auto wrong = check_call(control, device)) return wrong;
  auto& self = thing<Control>(control);
  if (!self.done()) return BISS_RUNNING;
  if (!self.queried) return BISS_NO_READING;
  *device = device_of(self.query);
  return BISS_OK;
}

}  // extern "C"

}  // namespace biss::capi
