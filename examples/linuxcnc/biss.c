/* A realtime HAL component of LinuxCNC that reads BiSS C encoders at SPI ports of Linux, one system
 * call for each cycle of the thread. docs/linuxcnc.md describes parameters, pins and limits. */
#include <hal.h>
#include <rtapi.h>
#include <rtapi_app.h>
#include <spidev_axis.h>

MODULE_DESCRIPTION("BiSS C encoders at SPI ports of Linux");
MODULE_LICENSE("Apache-2.0");

#define ENCODERS 8
#define CAUSES (BISS_AXIS_UNEXPECTED + 1)

static char* device[ENCODERS];
RTAPI_MP_ARRAY_STRING(device, ENCODERS, "SPI ports, as /dev/spidev0.0");
static char* format;
RTAPI_MP_STRING(format, "format of every encoder; or formats separated by |");
static int clock_hz[ENCODERS];
RTAPI_MP_ARRAY_INT(clock_hz, ENCODERS, "clock of MA in Hz");
static long max_step[ENCODERS];
RTAPI_MP_ARRAY_LONG(max_step, ENCODERS, "largest movement in one cycle and an eighth, in counts");
static int delay_ns = 2000;
RTAPI_MP_INT(delay_ns, "longest line delay: both directions of the cable, and the encoder");

/* In the shared memory of HAL. */
typedef struct encoder {
  hal_float_t *position, *velocity, *scale;
  hal_s32_t *counts, *turns;
  hal_u32_t *cause, *count[CAUSES];
  hal_bit_t *valid, *error, *warning, *tripped, *reset;
  bool reset_before;
  long period_ns; /* of the thread; 0 before its first cycle */
  spidev_axis* axis;
} encoder;

static spidev_axis axes[ENCODERS];
static int component;

static void read_encoder(void* of, long period_ns) {
  encoder* e = of;
  if (period_ns != e->period_ns) {
    spidev_axis_begin(e->axis, period_ns * INT64_C(1000));
    e->period_ns = period_ns;
  }
  if (*e->reset && !e->reset_before) biss_axis_reset(&e->axis->axis);
  e->reset_before = *e->reset;

  biss_axis_position now;
  spidev_axis_cycle(e->axis, &now);
  const double scale = *e->scale == 0 ? 1 : *e->scale;
  if (now.usable) { /* otherwise the last position stays */
    *e->position = (double)now.position / scale;
    *e->counts = (int32_t)now.position;
    *e->turns = (int32_t)(now.position >> e->axis->turn_bits);
  }
  *e->velocity = now.usable ? (double)now.step * 1e9 / (double)period_ns / scale : 0;
  *e->valid = now.usable;
  *e->tripped = now.state == BISS_AXIS_STOPPED;
  *e->error = !e->axis->nE;
  *e->warning = !e->axis->nW;
  *e->cause = now.cause;
  for (int i = 0; i < CAUSES; ++i) *e->count[i] = biss_axis_count(&e->axis->axis, i);
}

static int add_pins(encoder* e, int n) {
  int bad = hal_pin_float_newf(HAL_OUT, &e->position, component, "biss.%d.position", n) ||
            hal_pin_float_newf(HAL_OUT, &e->velocity, component, "biss.%d.velocity", n) ||
            hal_pin_float_newf(HAL_IO, &e->scale, component, "biss.%d.position-scale", n) ||
            hal_pin_s32_newf(HAL_OUT, &e->counts, component, "biss.%d.counts", n) ||
            hal_pin_s32_newf(HAL_OUT, &e->turns, component, "biss.%d.turns", n) ||
            hal_pin_u32_newf(HAL_OUT, &e->cause, component, "biss.%d.cause", n) ||
            hal_pin_bit_newf(HAL_OUT, &e->valid, component, "biss.%d.valid", n) ||
            hal_pin_bit_newf(HAL_OUT, &e->error, component, "biss.%d.error", n) ||
            hal_pin_bit_newf(HAL_OUT, &e->warning, component, "biss.%d.warning", n) ||
            hal_pin_bit_newf(HAL_OUT, &e->tripped, component, "biss.%d.tripped", n) ||
            hal_pin_bit_newf(HAL_IN, &e->reset, component, "biss.%d.reset", n);
  for (int i = 0; i < CAUSES && !bad; ++i) {
    bad = hal_pin_u32_newf(HAL_OUT, &e->count[i], component, "biss.%d.count.%s", n,
                           biss_axis_cause_name(i));
  }
  if (!bad) *e->scale = 1;
  return bad;
}

/* The n-th format, or the only one. */
static const char* format_of(int n, char* text, size_t room) {
  const char* from = format;
  for (const char* next; n > 0 && (next = strchr(from, '|')) != NULL; --n) from = next + 1;
  rtapi_snprintf(text, room, "%.*s", (int)strcspn(from, "|"), from);
  return text;
}

static const char* add_encoder(int n) {
  char text[BISS_FORMAT_TEXT_MAX], function[HAL_NAME_LEN + 1];
  const int hz = clock_hz[n] ? clock_hz[n] : clock_hz[0];
  const long step = max_step[n] ? max_step[n] : max_step[0];
  encoder* e = hal_malloc(sizeof *e);
  if (e == NULL) return "no memory of HAL";
  memset(e, 0, sizeof *e);
  e->axis = &axes[n];
  if (format == NULL || hz <= 0 || step <= 0 || delay_ns <= 0) {
    return "format=, clock_hz= and max_step= are necessary";
  }
  const char* wrong = spidev_axis_open(e->axis, device[n], format_of(n, text, sizeof text),
                                       (uint32_t)hz, delay_ns * INT64_C(1000), step);
  if (wrong != NULL) return wrong;
  rtapi_snprintf(function, sizeof function, "biss.%d.read", n);
  if (add_pins(e, n) || hal_export_funct(function, read_encoder, e, 1, 0, component)) {
    return "HAL has no room for its pins";
  }
  return NULL;
}

/* Not rtapi_app_exit(): a call of that name calls the one of the first module. */
static void leave(void) {
  hal_exit(component);
  for (int n = 0; n < ENCODERS; ++n) {
    if (axes[n].device > 0) close(axes[n].device);
  }
}

void rtapi_app_exit(void) { leave(); }

int rtapi_app_main(void) {
  component = hal_init("biss");
  if (component < 0) return component;
  const char* wrong = device[0] ? NULL : "necessary";
  for (int n = 0; n < ENCODERS && (device[n] || wrong); ++n) {
    if (!wrong) wrong = add_encoder(n);
    if (!wrong) continue;
    rtapi_print_msg(RTAPI_MSG_ERR, "biss: device=%s: %s\n", device[n] ? device[n] : "", wrong);
    leave();
    return -EINVAL;
  }
  return hal_ready(component);
}
