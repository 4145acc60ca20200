// The function of a control session that a master calls: biss_control for biss_master.
#pragma once

#include "biss/base/units.hpp"
#include "biss/control/session.hpp"
#include "capi/biss_c.h"

namespace biss::capi {

/// Takes the CDS of a frame. \return the CDM that ends it; false if the handle is not open
bool step_control(biss_control* control, Picoseconds now, CdsBit cds);

}  // namespace biss::capi
