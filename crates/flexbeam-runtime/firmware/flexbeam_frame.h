/* The rig's side of flexbeam's frame, version 1, for a microcontroller.
 *
 * Enters: bytes from UDP or a serial line, readings, a clock of milliseconds. Leaves: the voltage to apply, answers to send.
 * Deliberately absent: heap, global state, libm, interrupts, drivers. Nothing here waits.
 *
 * C99, any byte order, double of 64 bits (IEEE 754). Not re-entrant per object: a rig or a line belongs to one context, or
 * the caller shuts interrupts out. The protocol is described in the book, page "A rig behind UDP or a serial line". */
#ifndef FLEXBEAM_FRAME_H
#define FLEXBEAM_FRAME_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define FLEXBEAM_VERSION 1u
#define FLEXBEAM_COMMAND_BYTES 32u
#define FLEXBEAM_MEASUREMENT_BYTES 40u

/* Longest frame that a serial line takes in: more than version 1 needs, so that frames of other versions are answered. */
#define FLEXBEAM_LONGEST_FRAME 64u

/* A measurement on a serial line: one byte of overhead and a zero behind. */
#define FLEXBEAM_LINE_BYTES (FLEXBEAM_MEASUREMENT_BYTES + 2u)

/* In flexbeam_command.flags: 0 V now, and until a new session. */
#define FLEXBEAM_STOP 1u

/* In flexbeam_measurement.status. */
#define FLEXBEAM_TIMED_OUT 1u
#define FLEXBEAM_STOPPED 2u
#define FLEXBEAM_SENSOR_FAULT 4u

/* Host to rig: hold this voltage. */
struct flexbeam_command {
    uint32_t session;
    uint32_t sequence;
    uint16_t hold_ms; /* how long it may stand without a newer command */
    uint16_t flags;
    double voltage_v;
};

/* Rig to host: the sensors at the instant of the command that is answered. */
struct flexbeam_measurement {
    uint32_t session;
    uint32_t sequence;
    uint32_t status;
    double theta_rad; /* hub, counter-clockwise */
    double alpha_rad; /* tip against hub */
    uint32_t boots;   /* changes when the rig restarts */
};

enum flexbeam_fault {
    FLEXBEAM_OK,
    FLEXBEAM_BAD_MAGIC,
    FLEXBEAM_OTHER_VERSION,
    FLEXBEAM_BAD_LENGTH,
    FLEXBEAM_BAD_CHECKSUM,
    FLEXBEAM_OTHER_KIND
};

/* CRC-32 of IEEE 802.3. */
uint32_t flexbeam_crc32(const uint8_t *bytes, size_t length);

void flexbeam_encode_command(const struct flexbeam_command *command, uint8_t frame[FLEXBEAM_COMMAND_BYTES]);
void flexbeam_encode_measurement(const struct flexbeam_measurement *measurement,
                                 uint8_t frame[FLEXBEAM_MEASUREMENT_BYTES]);

/* Nothing is written unless FLEXBEAM_OK is returned. */
enum flexbeam_fault flexbeam_decode_command(const uint8_t *frame, size_t length, struct flexbeam_command *command);
enum flexbeam_fault flexbeam_decode_measurement(const uint8_t *frame, size_t length,
                                                struct flexbeam_measurement *measurement);

/* A frame as it goes out on a serial line: COBS and a zero behind it. Returns the bytes to send, at most length + 2;
 * 0 for a frame of more than FLEXBEAM_MEASUREMENT_BYTES. */
size_t flexbeam_line_encode(const uint8_t *frame, size_t length, uint8_t line[FLEXBEAM_LINE_BYTES]);

/* Finds frames in the bytes of a serial line. Zero-initialise it. */
struct flexbeam_line {
    uint8_t frame[FLEXBEAM_LONGEST_FRAME];
    uint16_t length; /* may exceed the room: then it is no frame of ours */
    uint8_t left;    /* bytes up to the next overhead byte */
    uint8_t inside;  /* 0: between frames; 1: in one; 2: in one, no zero is hidden in the next overhead byte */
};

/* Takes one byte. Returns -1 while a frame is under way, otherwise the length of the frame that ends here: 0 when what lay
 * before the zero is none, and never above FLEXBEAM_LONGEST_FRAME. */
int flexbeam_line_push(struct flexbeam_line *line, uint8_t byte);

/* Where a rig is in its session. */
enum flexbeam_phase {
    FLEXBEAM_IS_IDLE,    /* nobody has greeted it since it started */
    FLEXBEAM_IS_GREETED, /* and it does not move yet */
    FLEXBEAM_IS_RUNNING,
    FLEXBEAM_HAS_TIMED_OUT,
    FLEXBEAM_IS_STOPPED
};

/* One rig, and whom it obeys. Read voltage_v, leave the rest alone. */
struct flexbeam_rig {
    double voltage_v; /* apply this, always */
    enum flexbeam_phase phase;
    uint32_t boots;
    uint32_t session;
    uint32_t sequence;
    uint32_t since_ms;
    uint16_t hold_ms;
    uint8_t has_reply;
    uint8_t reply[FLEXBEAM_MEASUREMENT_BYTES];
};

/* At 0 V. boots is a number that no earlier start has had: a counter in non-volatile memory, or noise. */
void flexbeam_rig_init(struct flexbeam_rig *rig, uint32_t boots);

/* Every few milliseconds: takes the voltage away when no command came in time. now_ms may overflow. */
void flexbeam_rig_on_tick_ms(struct flexbeam_rig *rig, uint32_t now_ms);

/* What came from the host, with the readings of this moment; sensor_fault is 0 or FLEXBEAM_SENSOR_FAULT.
 * Returns the length of the answer to send: FLEXBEAM_MEASUREMENT_BYTES, or 0 for none. Apply rig->voltage_v afterwards. */
size_t flexbeam_rig_on_frame(struct flexbeam_rig *rig, const uint8_t *frame, size_t length, uint32_t now_ms,
                             double theta_rad, double alpha_rad, uint32_t sensor_fault,
                             uint8_t answer[FLEXBEAM_MEASUREMENT_BYTES]);

#ifdef __cplusplus
}
#endif

#endif
