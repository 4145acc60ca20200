#include "firmware/cost/row.hpp"

BISS_ROW(server_frame, "register server with two banks, one frame: CDS and CDM", server_frame) {
  const bool cds = s.server->cds(false);
  s.server->cdm(s.index != 0);
  return (cds ? 2U : 0U) | (s.server->idle() ? 1U : 0U);
}
