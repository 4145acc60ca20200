/* The master's side of the control communication: registers, commands, electronic data sheets
 * (EDS). Units, levels, errors and lifetimes are defined in biss_c.h.
 *
 * An access takes many frames, because each carries one bit in each direction. It begins with one
 * of the functions below; frames follow until biss_control_done(). They are made by a biss_master
 * whose setup has this session (biss_master_setup.control), or by the caller, who then calls
 * biss_control_step() once per frame. */
#pragma once

#include <biss_c.h>

BISS_C_BEGIN

BISS_OBJECT(biss_control, 124);

typedef struct biss_control_setup {
  int64_t busy_max_ps; /* the longest time by which a device may delay a byte; default 20 ms */
  uint32_t retries;    /* of an access that failed, possibly because of the line; up to 255. A byte
                          of a write whose echo was wrong may be written twice */
} biss_control_setup;

biss_control_setup biss_control_defaults(void);

/* Makes a session without an access. `setup` may be null: defaults. If the session ends before its
 * master, the master sends CDM 0 from then on; the memory must remain.
 * BISS_NULL_ARGUMENT, BISS_BAD_SETUP. */
biss_status biss_control_init(biss_control* control, const biss_control_setup* setup);

/* Begins to read `count` registers, 1 to 64, from `address` on, of the device with this ID, 0 to 7.
 * An access that no control frame can request is done at once, with bad_request.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_RUNNING: the last access is not done. */
biss_status biss_control_read(biss_control* control, uint32_t id, uint32_t address, size_t count);

/* Begins to write; `bytes` are copied. Errors as above, and BISS_NO_ROOM: more than 64. */
biss_status biss_control_write(biss_control* control, uint32_t id, uint32_t address,
                               const uint8_t* bytes, size_t count);

/* The four commands; their meaning depends on whether IDs or all devices are addressed. */
typedef enum biss_command BISS_INT {
  BISS_COMMAND_CHANNELS = 0, /* IDs: activate data channels; all: deactivate them */
  BISS_COMMAND_CONTROL,      /* IDs: deactivate control communication; all: activate it */
  BISS_COMMAND_BYPASS,       /* of bus couplers */
  BISS_COMMAND_USER          /* IDs: the device's own; all: reserved */
} biss_command;

/* When a command is executed. */
typedef enum biss_execute BISS_INT {
  BISS_EXECUTE_ALL_ACCEPT = 0, /* all addressed devices accept, and no other one */
  BISS_EXECUTE_ANY_ACCEPTS,    /* at least one of them, and no other one */
  BISS_EXECUTE_ALWAYS
} biss_execute;

/* Begins a command to the devices whose bits are 1 in `ids`, bit k for ID k.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_RUNNING, BISS_BAD_SETUP: no such command or
 * condition. */
biss_status biss_control_command(biss_control* control, uint32_t ids, biss_command command,
                                 biss_execute execute);

/* Begins a command to all devices, which has no answer. Errors as above. */
biss_status biss_control_broadcast(biss_control* control, biss_command command);

/* Ends an access with `cancelled`. BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_control_cancel(biss_control* control);

/* The CDS of a frame. */
typedef enum biss_cds BISS_INT {
  BISS_CDS_ZERO = 0,
  BISS_CDS_ONE,
  BISS_CDS_MISSING /* no answer, no START, or cut short */
} biss_cds;

/* Once per frame, also without an access, between its CDS and its end: *cdm is the CDM that ends
 * this frame. Not for a session that a biss_master has.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_TIME_RANGE, BISS_TIME_BACKWARDS, BISS_BAD_SETUP: no
 * such cds. */
biss_status biss_control_step(biss_control* control, int64_t now_ps, biss_cds cds, bool* cdm);

/* No access is under way. True without init. */
bool biss_control_done(const biss_control* control);

/* How an access ended, or how far it is. A query is many accesses: frames, tries and
 * longest_busy_ps are for all of them, the other numbers for the last one. */
typedef struct biss_control_outcome {
  /* Null: no error. Else the one cause: "bad_request", "no_answer", "no_such_slave", "id_pattern",
   * "refused", "not_addressed", "refused_or_not_addressed", "rw_pattern", "busy_too_long",
   * "start_missing", "data_crc", "echo", "next_unavailable", "not_accepted", "ida_pattern",
   * "frame_lost", "cancelled"; docs/c.md explains them. */
  const char* error;
  uint32_t bytes_done;      /* read with a right checksum, or written with a right echo */
  uint32_t devices_present; /* bit k: a device took ID k */
  uint32_t accepted;        /* of a command: bit k for ID k */
  uint32_t frames;
  uint32_t tries;
  int64_t longest_busy_ps; /* the longest time that a device delayed a byte */
} biss_control_outcome;

/* BISS_NULL_ARGUMENT, BISS_BAD_HANDLE. */
biss_status biss_control_outcome_of(const biss_control* control, biss_control_outcome* outcome);

/* The bytes that the last access has read: *count of them, at most `room`.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_NO_ROOM: `room` is too small; *count is what it must
 * be. */
biss_status biss_control_bytes(const biss_control* control, uint8_t* bytes, size_t room,
                               size_t* count);

/* ---- Electronic data sheets ---- */

/* The description of a device in its registers. */
typedef struct biss_device {
  bool has_identity;     /* registers 0x78 to 0x7F */
  uint64_t device_id;    /* 48 bits */
  uint32_t manufacturer; /* 16 bits, often two letters */
  bool has_serial;
  uint32_t serial;
  bool has_profile;
  uint32_t profile;  /* registers 0x42 and 0x43; 0: none */
  uint32_t eds_bank; /* register 0x41; 0: no EDS */
  bool eds_unused;   /* an EDS is there, but its checksum is wrong or it could not be read */
  bool bank_changed; /* the bank select register (0x40) may not have its first value */
  /* The parts of the EDS: the common one, and one for each data channel. */
  bool has_common;
  uint8_t common[64];
  bool has_channel[BISS_MAX_CHANNELS];
  uint8_t channel[BISS_MAX_CHANNELS][64];
} biss_device;

/* Begins to read identity, profile, serial number and EDS of the device with this ID. Parts that it
 * does not have are skipped; the bank select register is restored.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_RUNNING, BISS_BAD_SETUP: no such ID. */
biss_status biss_control_query(biss_control* control, uint32_t id);

/* The result of the last query. If biss_control_outcome.error is set, the query ended early.
 * BISS_NULL_ARGUMENT, BISS_BAD_HANDLE, BISS_RUNNING, BISS_NO_READING: no query was made. */
biss_status biss_control_device(const biss_control* control, biss_device* device);

/* Called for each finding of `biss eds check` (`used`: the right value, or the value of the field
 * it contradicts; 0: neither), then for each value of an EDS that is not used as it stands:
 * overridden by another source, corrected, unusable, not given, or of an uncertain meaning. Texts
 * are static. */
typedef void (*biss_eds_remark)(void* user, uint32_t channel, const char* field, const char* remark,
                                uint32_t stored, uint32_t used);

/* The frame format and, at this clock, the timing of a device by its EDS; with neither, by its
 * profile. `remark` may be null.
 * BISS_NULL_ARGUMENT, BISS_BAD_SETUP: clock_hz is 0, BISS_BAD_EDS: it has no data channel, the
 * length of one is not known, or it contradicts itself or the registers. */
biss_status biss_eds_format(const biss_device* device, uint32_t clock_hz, biss_format* format,
                            biss_eds_remark remark, void* user);

BISS_C_END
