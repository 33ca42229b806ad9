/* A rig on a serial line: the main loop. What begins with board_ is yours. */
#include "flexbeam_frame.h"

extern uint32_t board_boots(void);               /* counted up at each start, in non-volatile memory */
extern uint32_t board_now_ms(void);              /* a free-running clock */
extern int board_read_byte(void);                /* from the line's receive buffer; -1 when it is empty */
extern void board_write(const uint8_t *bytes, size_t length);
extern uint32_t board_read_sensors(double *theta_rad, double *alpha_rad); /* 0, or FLEXBEAM_SENSOR_FAULT */
extern void board_set_voltage(double voltage_v); /* to the amplifier, limited to what it can do */

static void answer(struct flexbeam_rig *rig, const uint8_t *frame, size_t length)
{
    uint8_t reply[FLEXBEAM_MEASUREMENT_BYTES];
    uint8_t line[FLEXBEAM_LINE_BYTES];
    double theta_rad = 0.0;
    double alpha_rad = 0.0;
    uint32_t fault = board_read_sensors(&theta_rad, &alpha_rad);
    size_t bytes = flexbeam_rig_on_frame(rig, frame, length, board_now_ms(), theta_rad, alpha_rad, fault, reply);
    board_set_voltage(rig->voltage_v);
    if (bytes > 0) {
        board_write(line, flexbeam_line_encode(reply, bytes, line));
    }
}

int main(void)
{
    struct flexbeam_rig rig;
    struct flexbeam_line line = {{0}, 0, 0, 0};
    flexbeam_rig_init(&rig, board_boots());
    for (;;) {
        int byte = board_read_byte();
        int length = byte < 0 ? -1 : flexbeam_line_push(&line, (uint8_t)byte);
        if (length > 0) {
            answer(&rig, line.frame, (size_t)length);
        }
        /* Apart from commands: the voltage ends in time even when none comes any more. A hardware watchdog belongs here. */
        flexbeam_rig_on_tick_ms(&rig, board_now_ms());
        board_set_voltage(rig.voltage_v);
    }
}
