/* Uses the installed C interface the way another project would. */
#include <biss_c.h>
#include <stdio.h>

static void sample(void* user, int64_t moment_ps, biss_channel* channels, size_t count) {
  (void)user;
  (void)moment_ps;
  (void)count;
  channels[0].position = 12345678;
}

int main(void) {
  biss_format format = biss_format_defaults();
  biss_slave_setup setup = biss_slave_defaults(&format);
  biss_slave slave;
  biss_output out;
  setup.sample = sample;
  biss_status status = biss_format_parse("resolute-26", &format);
  if (status == BISS_OK) status = biss_slave_init(&slave, &setup);
  if (status == BISS_OK) status = biss_slave_step(&slave, 0, false, false, &out);
  const bool works = status == BISS_OK && out.level && out.deadline_ps != BISS_NEVER;
  puts(works ? "the installed C interface works" : biss_status_text(status));
  return works ? 0 : 1;
}
