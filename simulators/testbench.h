/* Encoders, masters and scoreboards inside a simulation: the functions for the adapters of the
 * simulators (VPI, DPI-C, VHPIDIRECT) and for other C code. Built on biss_c.h.
 *
 *   Times     picoseconds of the simulation, never backwards.
 *   Levels    0 or 1.
 *   Names     each instance has its own. A call names its instance.
 *   Errors    are printed to stderr, and counted: biss_tb_report() does not return 0 then.
 *   Threads   one only.
 *
 * docs/simulators.md describes the settings. The types are the types of DPI-C: int, long long,
 * const char*. */
#pragma once

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#pragma GCC visibility push(default)
#endif

/* Makes an encoder that answers the design's master, or a master that reads the design's encoder.
 * Returns its number, above 0. 0: the settings are wrong or the name is taken; a line on stderr has
 * the reason. */
int biss_tb_encoder(const char* name, const char* settings);
int biss_tb_master(const char* name, const char* settings);

/* To be called at each change of the input, and at the time that the last call returned. Returns
 * when to call again if no input changes; -1: only an input matters, also
 * after biss_tb_report().
 * `request` 1 lets the master make requests, one after another. */
long long biss_tb_step_encoder(int id, long long now_ps, int ma);
long long biss_tb_step_master(int id, long long now_ps, int slo, int request);

/* The level that the instance drives since the last step: SLO for an encoder, MA for a master. */
int biss_tb_level(int id);
/* A master: first rising edges of MA (LAT) at the design so far. An encoder takes its position then.
 */
int biss_tb_latches(int id);
/* Requests that have ended. */
int biss_tb_requests(int id);

/* The next frame of this encoder has these values in `channel`, in place of the values in
 * its settings.
 * nE or nW below 0: the values have bits that are neither 0 nor 1, which is an error. */
void biss_tb_next(const char* name, int channel, long long position, int nE, int nW);

/* The scoreboard. For an encoder: the values that the design has read. For a master: the values that
 * the design was given at LAT. Call biss_tb_value() once for each channel, in any order, then
 * biss_tb_compare().
 *   known   0: the position has bits that are neither 0 nor 1
 *   cause   a cause of `biss decode` ("ok", "crc", "no_response", ...); "fault" if the design does
 *           not name the cause
 * biss_tb_compare() returns 1 unless it finds a mismatch. */
void biss_tb_value(const char* name, int channel, long long position, int known, int nE, int nW);
int biss_tb_compare(const char* name, const char* cause);

/* Prints the report, and writes it to PATH.txt and PATH.json unless `path` is empty. Removes all
 * instances. Returns the number of mismatches and errors; an instance that compared nothing is one.
 */
int biss_tb_report(const char* path);

#if defined(__GNUC__)
#pragma GCC visibility pop
#endif

#ifdef __cplusplus
}
#endif
