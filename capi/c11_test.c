/* The interface as a C program uses it; compiled as C11 without extensions. */
#include "capi/c11_test.h"

static void sample(void* user, int64_t moment_ps, biss_channel* channels, size_t count) {
  const uint64_t* position = user;
  (void)moment_ps;
  for (size_t k = 0; k < count; ++k) channels[k].position = *position;
}

static biss_status run(biss_slave* slave, biss_master* master, biss_reading* reading) {
  biss_output ma = {true, BISS_NEVER};
  biss_output slo = {true, BISS_NEVER};
  int64_t now = 0;
  biss_status status = biss_master_begin(master, now, slo.level, false, &ma);
  while (status == BISS_OK && !biss_master_done(master)) {
    status = biss_slave_step(slave, now, ma.level, false, &slo);
    if (status == BISS_OK) status = biss_master_step(master, now, slo.level, &ma);
    now = ma.deadline_ps < slo.deadline_ps ? ma.deadline_ps : slo.deadline_ps;
    if (status == BISS_OK && !biss_master_done(master)) {
      status = biss_master_step(master, now, slo.level, &ma);
    }
  }
  return status == BISS_OK ? biss_master_reading(master, reading) : status;
}

biss_status c11_read(const char* text, int64_t period_ps, uint64_t position,
                     biss_reading* reading) {
  biss_format format = biss_format_defaults();
  biss_status status = biss_format_parse(text, &format);
  biss_slave_setup slave_setup = biss_slave_defaults(&format);
  biss_master_setup master_setup = biss_master_defaults(&format, period_ps);
  biss_slave slave;
  biss_master master;
  master_setup.no_error_flag = true; /* of the catalogue, one encoder has no nE */
  slave_setup.sample = sample;
  slave_setup.user = &position;
  if (status == BISS_OK) status = biss_slave_init(&slave, &slave_setup);
  if (status == BISS_OK) status = biss_master_init(&master, &master_setup);
  return status == BISS_OK ? run(&slave, &master, reading) : status;
}
