// biss_turns: the core's TurnCounter.
#include "biss/turns/turn_counter.hpp"

#include "capi/biss_c_frame.h"
#include "capi/object.hpp"

namespace biss::capi {

static_assert(BISS_TURNS_AMBIGUOUS == static_cast<int>(TurnState::ambiguous));

extern "C" {

biss_status biss_turns_init(biss_turns* turns, uint32_t width_bits, uint64_t max_step) {
  if (const auto wrong = begin_init(turns)) return wrong;
  if (width_bits < 1 || width_bits > 64) return BISS_BIT_COUNT;
  return make<TurnCounter>(turns, width_bits,
                           max_step == 0 ? TurnCounter::widest_step(width_bits) : max_step);
}

biss_status biss_turns_update(biss_turns* turns, uint64_t count, uint64_t missed,
                              biss_turns_value* value) {
  if (const auto wrong = check_call(turns, value)) return wrong;
  thing<TurnCounter>(turns).update(count, missed);
  return biss_turns_position(turns, value);
}

biss_status biss_turns_resynchronise(biss_turns* turns, int64_t whole_turns,
                                     biss_turns_value* value) {
  if (const auto wrong = check_call(turns, value)) return wrong;
  thing<TurnCounter>(turns).resynchronise(whole_turns);
  return biss_turns_position(turns, value);
}

biss_status biss_turns_position(const biss_turns* turns, biss_turns_value* value) {
  if (const auto wrong = check_call(turns, value)) return wrong;
  const TurnCounter& counter = thing<TurnCounter>(turns);
  const auto position = counter.position();
  const bool known = counter.state() != TurnState::empty && position.has_value();
  *value = {static_cast<biss_turns_state>(counter.state()), counter.turns(), known,
            known ? *position : 0};
  return BISS_OK;
}

}  // extern "C"

}  // namespace biss::capi
