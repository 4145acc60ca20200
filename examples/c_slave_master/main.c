/* A master reads an encoder over 50 m of cable, in plain C. Both are steppers: this loop sets the
 * time, carries levels from one end to the other, and calls each stepper when it is due. */
#include <biss_c.h>
#include <inttypes.h>
#include <stdio.h>

#define ENCODER "resolute-26"
#define PERIOD_PS 100000      /* MA at 10 MHz */
#define ONE_WAY_PS 250000     /* 50 m, of which each adds 10 ns there and back */
#define INTERVAL_PS 50000000  /* a request every 50 us */
#define COUNTS_PER_MS 1000000 /* how fast the shaft turns */
#define CHANGES 64            /* a power of two, more than a cable holds */

/* A cable in one direction: changes that are on their way. */
typedef struct wire {
  int64_t arrival[CHANGES];
  bool level[CHANGES];
  unsigned first, end;
  bool sent, received;
} wire;

static void put(wire* cable, int64_t now, bool level) {
  if (level == cable->sent) return;
  cable->sent = level;
  cable->arrival[cable->end % CHANGES] = now + ONE_WAY_PS;
  cable->level[cable->end++ % CHANGES] = level;
}

static int64_t due(const wire* cable) {
  return cable->first == cable->end ? BISS_NEVER : cable->arrival[cable->first % CHANGES];
}

static void take(wire* cable, int64_t now) {
  while (due(cable) <= now) cable->received = cable->level[cable->first++ % CHANGES];
}

static int64_t earlier(int64_t a, int64_t b) { return a < b ? a : b; }

/* The shaft as the encoder sees it at the sampling moment. */
static uint64_t position_at(int64_t moment_ps) {
  return (uint64_t)(moment_ps / (1000000000 / COUNTS_PER_MS)) & ((1U << 26) - 1U);
}

static void sample(void* user, int64_t moment_ps, biss_channel* channels, size_t count) {
  (void)count; /* this format has one channel */
  channels[0].position = position_at(moment_ps);
  *(uint64_t*)user = channels[0].position;
}

typedef struct line {
  biss_slave slave;
  biss_master master;
  wire ma, slo;
  biss_output slave_out, master_out;
} line;

/* One request, from `now` until the encoder is ready again. */
static biss_status request(line* l, int64_t now) {
  biss_status status = biss_master_begin(&l->master, now, l->slo.received, false, &l->master_out);
  while (status == BISS_OK && !biss_master_done(&l->master)) {
    put(&l->ma, now, l->master_out.level);
    now = earlier(earlier(due(&l->ma), due(&l->slo)),
                  earlier(l->master_out.deadline_ps, l->slave_out.deadline_ps));
    take(&l->ma, now);
    take(&l->slo, now);
    status = biss_slave_step(&l->slave, now, l->ma.received, false, &l->slave_out);
    put(&l->slo, now, l->slave_out.level);
    if (status == BISS_OK) {
      status = biss_master_step(&l->master, now, l->slo.received, &l->master_out);
    }
  }
  return status;
}

/* 0 if the position read is the position that the encoder sampled. */
static int show(const biss_reading* reading, uint64_t sent) {
  printf("%8.1f us  %-11s", (double)reading->begin_ps / 1e6, biss_cause_name(reading->cause));
  if (reading->cause != BISS_CAUSE_OK) {
    puts("");
    return 1;
  }
  printf("  position %8" PRIu64 "  nE %d  nW %d  line delay %.1f ns  ACK %" PRIu32 " clocks\n",
         reading->channels[0].position, reading->channels[0].nE, reading->channels[0].nW,
         (double)reading->line_delay_ps / 1e3, reading->ack_clocks);
  return reading->channels[0].position == sent ? 0 : 1;
}

static int run(line* l, const uint64_t* sent) {
  int wrong = 0;
  for (int i = 0; i < 8; ++i) {
    biss_reading reading;
    biss_status status = request(l, i * (int64_t)INTERVAL_PS);
    if (status == BISS_OK) status = biss_master_reading(&l->master, &reading);
    if (status != BISS_OK) {
      fprintf(stderr, "%s: %s\n", biss_status_name(status), biss_status_text(status));
      return 1;
    }
    wrong += show(&reading, *sent);
  }
  return wrong == 0 ? 0 : 1;
}

int main(void) {
  uint64_t sent = 0;
  biss_format format = biss_format_defaults();
  biss_slave_setup slave = biss_slave_defaults(&format);
  biss_master_setup master = biss_master_defaults(&format, PERIOD_PS);
  const wire idle = {{0}, {0}, 0, 0, true, true};
  static line l;
  l.ma = l.slo = idle;
  l.slave_out = l.master_out = (biss_output){true, BISS_NEVER};
  int result = 1;
  slave.sample = sample;
  slave.user = &sent;
  biss_status status = biss_format_parse(ENCODER, &format);
  if (status == BISS_OK) status = biss_slave_init(&l.slave, &slave);
  if (status == BISS_OK) status = biss_master_init(&l.master, &master);
  if (status == BISS_OK) {
    result = run(&l, &sent);
  } else {
    fprintf(stderr, "%s: %s\n", biss_status_name(status), biss_status_text(status));
  }
  return result;
}
