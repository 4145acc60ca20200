// biss_control: a handle of the core's ControlSession, and of the query of one device.
#include "capi/control.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "biss/configure/configurator.hpp"
#include "biss/control/session.hpp"
#include "biss/eds/device.hpp"
#include "capi/biss_c_control.h"
#include "capi/device.hpp"

struct biss_control {
  explicit biss_control(const biss::ControlOptions& options) : session(options) {}

  bool done() const { return session.done() && !querying; }

  bool step(biss::Picoseconds now, biss::CdsBit cds) {
    const bool bit = session.step(now, cds);
    while (querying && session.done()) advance();
    return bit;
  }

  /// The next access of a query. \pre querying, and the last one is done
  void advance() {
    const biss::ControlOutcome last = session.outcome();
    querying = query.advance(session) || begins_eds();
    if (!querying) return;
    earlier_frames += last.frames;
    earlier_tries += last.tries;
    earlier_busy = std::max(earlier_busy, last.longest_busy);
  }

  /// After everything else of the device comes its EDS, if it has one.
  bool begins_eds() {
    if (query.failed() || query.step() != biss::ConfigureStep::find_eds) return false;
    const biss::SlaveDescription& found = query.description();
    return query.names_eds(found) && query.begin_eds(session, id, found);
  }

  biss::ControlSession session;
  std::array<std::uint8_t, biss::sequential_max_bytes> bytes{};
  std::size_t read_count = 0;
  biss::configure_detail::SlaveQuery query;
  // The numbers of all accesses of a query but the last one.
  std::uint32_t earlier_frames = 0;
  std::uint32_t earlier_tries = 0;
  biss::Picoseconds earlier_busy{};
  std::uint8_t id = 0;  // of the device that is queried
  bool querying = false;
  bool queried = false;  // the last access was a query
  biss::capi::Clock clock;
};

namespace biss::capi {

bool step_control(biss_control* control, Picoseconds now, CdsBit cds) {
  return is_open(control) && control->step(now, cds);
}

namespace {

static_assert(BISS_COMMAND_USER == static_cast<int>(ControlCommand::user));
static_assert(BISS_EXECUTE_ALWAYS == static_cast<int>(ExecuteIf::always));
static_assert(BISS_CDS_MISSING == static_cast<int>(CdsBit::missing));

// Whether an access can begin; then nothing is read yet.
biss_status begin(biss_control* control) {
  if (const auto wrong = check_call(control)) return wrong;
  if (!control->done()) return BISS_RUNNING;
  control->read_count = 0;
  control->queried = false;
  control->earlier_frames = control->earlier_tries = 0;
  control->earlier_busy = {};
  return BISS_OK;
}

const char* error_of(const biss_control& control) {
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

}  // namespace biss::capi

using namespace biss::capi;

extern "C" {

biss_control_setup biss_control_defaults(void) {
  return {biss::ControlOptions{}.busy_max.count, 0};
}

biss_status biss_control_open(const biss_control_setup* setup, biss_control** control) {
  if (control == nullptr) return BISS_NULL_ARGUMENT;
  *control = nullptr;
  const biss_control_setup chosen = setup == nullptr ? biss_control_defaults() : *setup;
  constexpr std::uint32_t most = std::numeric_limits<std::uint8_t>::max();
  if (!is_duration(chosen.busy_max_ps) || chosen.retries > most) return BISS_BAD_SETUP;
  return open_handle(*control,
                     biss::ControlOptions{.busy_max = biss::picoseconds(chosen.busy_max_ps),
                                          .retries = static_cast<std::uint8_t>(chosen.retries)});
}

void biss_control_close(biss_control* control) { destroy_handle(control); }

biss_status biss_control_read(biss_control* control, uint32_t id, uint32_t address, size_t count) {
  if (const auto wrong = begin(control)) return wrong;
  // A request for more registers than fit becomes an impossible request: bad_request.
  const bool fits = count <= control->bytes.size();
  control->read_count = fits ? count : 0;
  control->session.read(fits ? id : biss::control_max_slaves, address,
                        std::span(control->bytes).first(control->read_count));
  return BISS_OK;
}

biss_status biss_control_write(biss_control* control, uint32_t id, uint32_t address,
                               const uint8_t* bytes, size_t count) {
  if (control != nullptr && bytes == nullptr) return BISS_NULL_ARGUMENT;
  if (count > biss::sequential_max_bytes) return BISS_NO_ROOM;
  if (const auto wrong = begin(control)) return wrong;
  std::copy_n(bytes, count, control->bytes.begin());
  control->session.write(id, address, std::span(control->bytes).first(count));
  return BISS_OK;
}

biss_status biss_control_command(biss_control* control, uint32_t ids, biss_command command,
                                 biss_execute execute) {
  if (control == nullptr) return BISS_NULL_ARGUMENT;
  if (ids > 0xFFU || command < BISS_COMMAND_CHANNELS || command > BISS_COMMAND_USER ||
      execute < BISS_EXECUTE_ALL_ACCEPT || execute > BISS_EXECUTE_ALWAYS) {
    return BISS_BAD_SETUP;
  }
  if (const auto wrong = begin(control)) return wrong;
  control->session.command(static_cast<std::uint8_t>(ids),
                           static_cast<biss::ControlCommand>(command),
                           static_cast<biss::ExecuteIf>(execute));
  return BISS_OK;
}

biss_status biss_control_broadcast(biss_control* control, biss_command command) {
  if (control == nullptr) return BISS_NULL_ARGUMENT;
  if (command < BISS_COMMAND_CHANNELS || command > BISS_COMMAND_USER) return BISS_BAD_SETUP;
  if (const auto wrong = begin(control)) return wrong;
  control->session.broadcast(static_cast<biss::ControlCommand>(command));
  return BISS_OK;
}

biss_status biss_control_cancel(biss_control* control) {
  if (const auto wrong = check_call(control)) return wrong;
  control->session.cancel();
  while (control->querying && control->session.done()) {
    control->advance();
    control->session.cancel();
  }
  return BISS_OK;
}

biss_status biss_control_step(biss_control* control, int64_t now_ps, biss_cds cds, bool* cdm) {
  if (const auto wrong = check_call(control, cdm)) return wrong;
  if (cds < BISS_CDS_ZERO || cds > BISS_CDS_MISSING) return BISS_BAD_SETUP;
  if (const auto wrong = control->clock.check(now_ps)) return wrong;
  control->clock.set(now_ps);
  *cdm = control->step(biss::picoseconds(now_ps), static_cast<biss::CdsBit>(cds));
  return BISS_OK;
}

bool biss_control_done(const biss_control* control) { return !is_open(control) || control->done(); }

biss_status biss_control_outcome_of(const biss_control* control, biss_control_outcome* outcome) {
  if (const auto wrong = check_call(control, outcome)) return wrong;
  const biss::ControlOutcome& from = control->session.outcome();
  *outcome = {.error = error_of(*control),
              .bytes_done = from.bytes_done,
              .devices_present = from.slaves_present,
              .accepted = from.accepted,
              .frames = control->earlier_frames + from.frames,
              .tries = control->earlier_tries + from.tries,
              .longest_busy_ps = std::max(control->earlier_busy, from.longest_busy).count};
  return BISS_OK;
}

biss_status biss_control_bytes(const biss_control* control, uint8_t* bytes, size_t room,
                               size_t* count) {
  if (const auto wrong = check_call(control, bytes, count)) return wrong;
  *count = std::min<std::size_t>(control->read_count, control->session.outcome().bytes_done);
  if (*count > room) return BISS_NO_ROOM;
  std::copy_n(control->bytes.begin(), *count, bytes);
  return BISS_OK;
}

biss_status biss_control_query(biss_control* control, uint32_t id) {
  if (control == nullptr) return BISS_NULL_ARGUMENT;
  if (id >= biss::control_max_slaves) return BISS_BAD_SETUP;
  if (const auto wrong = begin(control)) return wrong;
  control->id = static_cast<std::uint8_t>(id);
  control->query.begin(control->session, control->id);
  control->querying = control->queried = true;
  return BISS_OK;
}

biss_status biss_control_device(const biss_control* control, biss_device* device) {
  if (const auto wrong = check_call(control, device)) return wrong;
  if (!control->done()) return BISS_RUNNING;
  if (!control->queried) return BISS_NO_READING;
  *device = device_of(control->query);
  return BISS_OK;
}

}  // extern "C"
