/* See flexbeam_frame.h. */
#include "flexbeam_frame.h"

#include <string.h>

enum { COMMAND = 1, MEASUREMENT = 2, CHECKSUM_BYTES = 4, HEAD_BYTES = 4 };

/* A compiler whose double has 32 bits (AVR) stops here: give it one of 64, or take theta and alpha apart by hand. */
typedef char flexbeam_needs_a_double_of_64_bits[sizeof(double) == 8 ? 1 : -1];

/* ---- Numbers, little-endian ---- */

static uint8_t *put(uint8_t *to, uint64_t value, size_t bytes)
{
    for (size_t k = 0; k < bytes; ++k) {
        to[k] = (uint8_t)(value >> (8u * k));
    }
    return to + bytes;
}

static uint8_t *put_double(uint8_t *to, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return put(to, bits, sizeof bits);
}

static uint64_t take(const uint8_t **from, size_t bytes)
{
    uint64_t value = 0;
    for (size_t k = 0; k < bytes; ++k) {
        value |= (uint64_t)(*from)[k] << (8u * k);
    }
    *from += bytes;
    return value;
}

static double take_double(const uint8_t **from)
{
    uint64_t bits = take(from, sizeof bits);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Compiled with -ffast-math, comparisons and isfinite() may be folded away; the exponent's bits may not. */
static int is_finite(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return ((bits >> 52) & 0x7FFu) != 0x7FFu;
}

/* ---- Frames ---- */

/* Half a byte at a time: 64 bytes of table. */
uint32_t flexbeam_crc32(const uint8_t *bytes, size_t length)
{
    static const uint32_t table[16] = {
        0x00000000u, 0x1DB71064u, 0x3B6E20C8u, 0x26D930ACu, 0x76DC4190u, 0x6B6B51F4u, 0x4DB26158u, 0x5005713Cu,
        0xEDB88320u, 0xF00F9344u, 0xD6D6A3E8u, 0xCB61B38Cu, 0x9B64C2B0u, 0x86D3D2D4u, 0xA00AE278u, 0xBDBDF21Cu,
    };
    uint32_t crc = 0xFFFFFFFFu;
    for (size_t k = 0; k < length; ++k) {
        crc = (crc >> 4) ^ table[(crc ^ bytes[k]) & 15u];
        crc = (crc >> 4) ^ table[(crc ^ ((uint32_t)bytes[k] >> 4)) & 15u];
    }
    return crc ^ 0xFFFFFFFFu;
}

static uint8_t *put_head(uint8_t *frame, uint8_t kind, uint32_t session, uint32_t sequence)
{
    frame[0] = 'F';
    frame[1] = 'B';
    frame[2] = FLEXBEAM_VERSION;
    frame[3] = kind;
    return put(put(frame + HEAD_BYTES, session, 4), sequence, 4);
}

static void seal(uint8_t *frame, size_t length)
{
    put(frame + length - CHECKSUM_BYTES, flexbeam_crc32(frame, length - CHECKSUM_BYTES), CHECKSUM_BYTES);
}

void flexbeam_encode_command(const struct flexbeam_command *command, uint8_t frame[FLEXBEAM_COMMAND_BYTES])
{
    uint8_t *to = put_head(frame, COMMAND, command->session, command->sequence);
    to = put(to, command->hold_ms, 2);
    to = put(to, command->flags, 2);
    to = put_double(to, command->voltage_v);
    put(to, 0, 4);
    seal(frame, FLEXBEAM_COMMAND_BYTES);
}

void flexbeam_encode_measurement(const struct flexbeam_measurement *measurement,
                                 uint8_t frame[FLEXBEAM_MEASUREMENT_BYTES])
{
    uint8_t *to = put_head(frame, MEASUREMENT, measurement->session, measurement->sequence);
    to = put(to, measurement->status, 4);
    to = put_double(to, measurement->theta_rad);
    to = put_double(to, measurement->alpha_rad);
    put(to, measurement->boots, 4);
    seal(frame, FLEXBEAM_MEASUREMENT_BYTES);
}

/* In every version the last four bytes are the check sum of all before them. */
static int is_sealed(const uint8_t *frame, size_t length)
{
    const uint8_t *tail = frame + length - CHECKSUM_BYTES;
    return take(&tail, CHECKSUM_BYTES) == flexbeam_crc32(frame, length - CHECKSUM_BYTES);
}

static enum flexbeam_fault opened(const uint8_t *frame, size_t length, uint8_t kind, size_t needed)
{
    if (length < HEAD_BYTES) {
        return FLEXBEAM_BAD_LENGTH;
    }
    if (frame[0] != 'F' || frame[1] != 'B') {
        return FLEXBEAM_BAD_MAGIC;
    }
    if (frame[2] != FLEXBEAM_VERSION) {
        return FLEXBEAM_OTHER_VERSION;
    }
    if (length != FLEXBEAM_COMMAND_BYTES && length != FLEXBEAM_MEASUREMENT_BYTES) {
        return FLEXBEAM_BAD_LENGTH;
    }
    if (!is_sealed(frame, length)) {
        return FLEXBEAM_BAD_CHECKSUM;
    }
    if (frame[3] != kind) {
        return FLEXBEAM_OTHER_KIND;
    }
    return length == needed ? FLEXBEAM_OK : FLEXBEAM_BAD_LENGTH;
}

enum flexbeam_fault flexbeam_decode_command(const uint8_t *frame, size_t length, struct flexbeam_command *command)
{
    enum flexbeam_fault fault = opened(frame, length, COMMAND, FLEXBEAM_COMMAND_BYTES);
    if (fault == FLEXBEAM_OK) {
        const uint8_t *from = frame + HEAD_BYTES;
        command->session = (uint32_t)take(&from, 4);
        command->sequence = (uint32_t)take(&from, 4);
        command->hold_ms = (uint16_t)take(&from, 2);
        command->flags = (uint16_t)take(&from, 2);
        command->voltage_v = take_double(&from);
    }
    return fault;
}

enum flexbeam_fault flexbeam_decode_measurement(const uint8_t *frame, size_t length,
                                                struct flexbeam_measurement *measurement)
{
    enum flexbeam_fault fault = opened(frame, length, MEASUREMENT, FLEXBEAM_MEASUREMENT_BYTES);
    if (fault == FLEXBEAM_OK) {
        const uint8_t *from = frame + HEAD_BYTES;
        measurement->session = (uint32_t)take(&from, 4);
        measurement->sequence = (uint32_t)take(&from, 4);
        measurement->status = (uint32_t)take(&from, 4);
        measurement->theta_rad = take_double(&from);
        measurement->alpha_rad = take_double(&from);
        measurement->boots = (uint32_t)take(&from, 4);
    }
    return fault;
}

/* ---- The serial line: COBS ---- */

size_t flexbeam_line_encode(const uint8_t *frame, size_t length, uint8_t line[FLEXBEAM_LINE_BYTES])
{
    if (length > FLEXBEAM_MEASUREMENT_BYTES) {
        return 0;
    }
    size_t overhead = 0; /* where the distance to the next zero is to stand */
    size_t at = 1;
    for (size_t k = 0; k < length; ++k) {
        if (frame[k] == 0) {
            line[overhead] = (uint8_t)(at - overhead);
            overhead = at;
        } else {
            line[at] = frame[k];
        }
        ++at;
    }
    line[overhead] = (uint8_t)(at - overhead);
    line[at] = 0;
    return at + 1;
}

static void keep(struct flexbeam_line *line, uint8_t byte)
{
    if (line->length < FLEXBEAM_LONGEST_FRAME) {
        line->frame[line->length] = byte;
    }
    if (line->length < UINT16_MAX) {
        ++line->length;
    }
}

/* A zero ends the frame, whole or not. */
static int line_end(struct flexbeam_line *line)
{
    int whole = line->inside != 0 && line->left == 0 && line->length <= FLEXBEAM_LONGEST_FRAME;
    int answer = line->inside == 0 ? -1 : whole ? (int)line->length : 0;
    line->inside = 0;
    return answer;
}

int flexbeam_line_push(struct flexbeam_line *line, uint8_t byte)
{
    if (byte == 0) {
        return line_end(line);
    }
    if (line->inside != 0 && line->left > 0) {
        keep(line, byte);
        --line->left;
        return -1;
    }
    if (line->inside == 0) {
        line->length = 0;
    } else if (line->inside == 1) {
        keep(line, 0);
    }
    line->left = (uint8_t)(byte - 1);
    line->inside = byte == 0xFF ? 2 : 1;
    return -1;
}

/* ---- The rig ---- */

void flexbeam_rig_init(struct flexbeam_rig *rig, uint32_t boots)
{
    memset(rig, 0, sizeof *rig);
    rig->voltage_v = 0.0;
    rig->phase = FLEXBEAM_IS_IDLE;
    rig->boots = boots;
}

static void rest(struct flexbeam_rig *rig, enum flexbeam_phase phase)
{
    rig->phase = phase;
    rig->voltage_v = 0.0;
}

void flexbeam_rig_on_tick_ms(struct flexbeam_rig *rig, uint32_t now_ms)
{
    if (rig->phase == FLEXBEAM_IS_RUNNING && (uint32_t)(now_ms - rig->since_ms) > rig->hold_ms) {
        rest(rig, FLEXBEAM_HAS_TIMED_OUT);
    }
}

static void obey(struct flexbeam_rig *rig, const struct flexbeam_command *command, uint32_t now_ms)
{
    rig->sequence = command->sequence;
    rig->voltage_v = is_finite(command->voltage_v) ? command->voltage_v : 0.0;
    rig->hold_ms = command->hold_ms;
    rig->since_ms = now_ms;
}

enum decision { IGNORE, REPEAT, READ };

/* Only a greeting opens a session: a straggler of an earlier one neither moves the rig nor ends the run. */
static enum decision on_stranger(struct flexbeam_rig *rig, const struct flexbeam_command *command, int greets)
{
    if (greets && !(command->flags & FLEXBEAM_STOP)) {
        rig->session = command->session;
        rig->sequence = command->sequence;
        rig->has_reply = 0;
        rest(rig, FLEXBEAM_IS_GREETED);
        return READ;
    }
    return rig->phase == FLEXBEAM_IS_IDLE ? READ : IGNORE;
}

/* A command of a session that has begun, or has ended: the newest sequence wins. */
static enum decision on_known(struct flexbeam_rig *rig, const struct flexbeam_command *command, uint32_t now_ms)
{
    uint32_t ahead = command->sequence - rig->sequence;
    if (ahead > INT32_MAX) {
        return IGNORE;
    }
    if (ahead == 0 && rig->has_reply) {
        return REPEAT;
    }
    if (rig->phase == FLEXBEAM_IS_RUNNING) {
        obey(rig, command, now_ms);
    } else {
        rig->sequence = command->sequence;
    }
    return READ;
}

static enum decision on_command(struct flexbeam_rig *rig, const struct flexbeam_command *command, uint32_t now_ms)
{
    int greets = command->sequence > INT32_MAX;
    if (rig->phase == FLEXBEAM_IS_IDLE || command->session != rig->session) {
        return on_stranger(rig, command, greets);
    }
    if (command->flags & FLEXBEAM_STOP) {
        rest(rig, FLEXBEAM_IS_STOPPED);
        return READ;
    }
    if (rig->phase != FLEXBEAM_IS_GREETED) {
        return on_known(rig, command, now_ms);
    }
    if (!greets) {
        rig->phase = FLEXBEAM_IS_RUNNING;
        obey(rig, command, now_ms);
    }
    return READ;
}

static uint32_t status_of(const struct flexbeam_rig *rig)
{
    switch (rig->phase) {
    case FLEXBEAM_IS_GREETED:
    case FLEXBEAM_IS_RUNNING:
        return 0;
    case FLEXBEAM_IS_STOPPED:
        return FLEXBEAM_STOPPED;
    case FLEXBEAM_IS_IDLE:
    case FLEXBEAM_HAS_TIMED_OUT:
        break;
    }
    return FLEXBEAM_TIMED_OUT;
}

/* A host of another version learns ours, unless that would disturb a run. */
static size_t on_other_version(const struct flexbeam_rig *rig, const uint8_t *frame, size_t length,
                               uint8_t answer[FLEXBEAM_MEASUREMENT_BYTES])
{
    if (rig->phase == FLEXBEAM_IS_RUNNING || length < HEAD_BYTES + CHECKSUM_BYTES || frame[3] != COMMAND ||
        !is_sealed(frame, length)) {
        return 0;
    }
    struct flexbeam_measurement measurement = {0, 0, status_of(rig), 0.0, 0.0, rig->boots};
    flexbeam_encode_measurement(&measurement, answer);
    return FLEXBEAM_MEASUREMENT_BYTES;
}

size_t flexbeam_rig_on_frame(struct flexbeam_rig *rig, const uint8_t *frame, size_t length, uint32_t now_ms,
                             double theta_rad, double alpha_rad, uint32_t sensor_fault,
                             uint8_t answer[FLEXBEAM_MEASUREMENT_BYTES])
{
    struct flexbeam_command command;
    flexbeam_rig_on_tick_ms(rig, now_ms);
    enum flexbeam_fault fault = flexbeam_decode_command(frame, length, &command);
    if (fault != FLEXBEAM_OK) {
        return fault == FLEXBEAM_OTHER_VERSION ? on_other_version(rig, frame, length, answer) : 0;
    }
    enum decision decision = on_command(rig, &command, now_ms);
    if (decision == IGNORE) {
        return 0;
    }
    if (decision == REPEAT) {
        memcpy(answer, rig->reply, sizeof rig->reply);
        return sizeof rig->reply;
    }
    struct flexbeam_measurement measurement = {
        command.session, command.sequence, status_of(rig) | sensor_fault, theta_rad, alpha_rad, rig->boots,
    };
    flexbeam_encode_measurement(&measurement, answer);
    if (rig->phase != FLEXBEAM_IS_IDLE && command.sequence == rig->sequence) {
        memcpy(rig->reply, answer, sizeof rig->reply);
        rig->has_reply = 1;
    }
    return FLEXBEAM_MEASUREMENT_BYTES;
}
