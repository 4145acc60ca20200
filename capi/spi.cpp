// biss_spi: the core's SpiReader.
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>

#include "biss/master/spi_read.hpp"
#include "capi/frame.hpp"

namespace biss::capi {

namespace {

constexpr std::int64_t spi_period_min_ps = 32;

bool is_possible(const biss_spi_setup& setup) {
  return are_durations({setup.period_ps, setup.line_delay_min_ps, setup.line_delay_max_ps}) &&
         setup.period_ps >= spi_period_min_ps &&
         setup.line_delay_min_ps <= setup.line_delay_max_ps && setup.first_bit <= UINT16_MAX;
}

SpiSetup from_c(const biss_spi_setup& setup) {
  return {
      .period = picoseconds(setup.period_ps),
      .phase = setup.sample_on_falling ? SpiPhase::sample_on_falling : SpiPhase::sample_on_rising,
      .line_delay = {picoseconds(setup.line_delay_min_ps), picoseconds(setup.line_delay_max_ps)},
      .first_bit = static_cast<std::uint16_t>(setup.first_bit),
      .tail = setup.ignore_tail ? SpiTail::ignored : SpiTail::must_stay_low,
      .no_error_flag = setup.no_error_flag,
      .unchecked = setup.unchecked};
}

}  // namespace

biss_status check_spi(const Described& device, const SpiSetup& setup) {
  const auto error = check_spi(device.format, setup, device.timing);
  // One for each SpiSetupError.
  static constexpr biss_status statuses[] = {
      BISS_BAD_SETUP,  BISS_BAD_SETUP, BISS_CLOCK_MAX, BISS_NO_ERROR_FLAG, BISS_NO_CRC,
      BISS_BAD_FORMAT, BISS_BAD_SETUP, BISS_BAD_SETUP, BISS_BAD_SETUP,     BISS_BAD_SETUP};
  static_assert(std::size(statuses) == 1U + static_cast<unsigned>(SpiSetupError::time_step));
  return error ? statuses[static_cast<std::size_t>(*error)] : BISS_OK;
}

extern "C" {

biss_spi_setup biss_spi_defaults(const biss_format* format, int64_t period_ps) {
  biss_spi_setup setup{};
  setup.format = format;
  setup.period_ps = period_ps;
  setup.line_delay_max_ps = LineDelayRange{}.max.count;
  return setup;
}

biss_status biss_spi_init(biss_spi* spi, const biss_spi_setup* setup) {
  if (const auto wrong = begin_init(spi, setup)) return wrong;
  Described device;
  if (const auto wrong = read(setup->format, device)) return wrong;
  if (!is_possible(*setup)) return BISS_BAD_SETUP;
  const SpiSetup chosen = from_c(*setup);
  if (const auto refused = check_spi(device, chosen)) return refused;
  return make<Spi>(spi, device, chosen);
}

biss_status biss_spi_size_of(const biss_spi* spi, biss_spi_size* size) {
  if (const auto wrong = check_call(spi, size)) return wrong;
  const auto& reader = thing<Spi>(spi).reader;
  *size = {reader.clocks(), reader.bytes(), std::bit_cast<biss_bounds>(reader.bounds())};
  return BISS_OK;
}

biss_status biss_spi_read(const biss_spi* spi, const uint8_t* bytes, size_t byte_count,
                          size_t clocks, biss_frame* frame) {
  if (const auto wrong = check_call(spi, frame, given(bytes, byte_count))) return wrong;
  put(thing<Spi>(spi).reader.read(std::span(bytes, byte_count), clocks), *frame);
  return BISS_OK;
}

biss_status biss_spi_line_delay(const biss_spi* spi, const biss_frame* frame, int64_t* min_ps,
                                int64_t* max_ps) {
  if (const auto wrong = check_call(spi, frame, min_ps, max_ps)) return wrong;
  if (frame->cause != BISS_CAUSE_OK) return BISS_NO_READING;
  const FrameBounds& bounds = thing<Spi>(spi).reader.bounds();
  if (frame->lead_clocks < bounds.lead_min_clocks || frame->lead_clocks > bounds.lead_max_clocks) {
    return BISS_CLOCK_RANGE;
  }
  Frame lead;
  lead.lead_clocks = static_cast<std::uint16_t>(frame->lead_clocks);
  const LineDelayRange range = observed_line_delay(lead, thing<Spi>(spi).setup);
  *min_ps = range.min.count;
  *max_ps = range.max.count;
  return BISS_OK;
}

}  // extern "C"

}  // namespace biss::capi
