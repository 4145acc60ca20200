/* Functions of the C11 unit of the tests for the C++ ones. */
#pragma once

#include "capi/biss_c.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One request of a master to an encoder that stands at `position`, on a line without delay, in
 * plain C. Returns the first status that is not BISS_OK. */
biss_status c11_read(const char* text, int64_t period_ps, uint64_t position, biss_reading* reading);

#ifdef __cplusplus
}
#endif
