/* @TITLE@
 *
@BANNER@
 *
 * One call of NAME_tick() a period, from measurement to voltage:
 *   scale, filter, limits on the measurements, smooth reference, controller, variable-structure law, voltage limit,
 *   u_applied, state update, non-finite check.
 * It allocates nothing, waits for nothing, calls nothing of libm and keeps nothing but the state that its caller owns. It has an
 * answer for any numbers; all numbers that it answers are finite.
 *
 * C99, IEEE 754 arithmetic. Build with -ffp-contract=off and without -ffast-math: then the answers have the same bits on every
 * machine. NAME_selfcheck() finds a compiler or a processor that computes otherwise; call it once at start. */
#ifndef UPPER_H
#define UPPER_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Number of states n of the controller. */
#define UPPER_ORDER @ORDER@

/* Sample period [s]: how often NAME_tick() is to be called. */
#define UPPER_PERIOD_S @PERIOD@

/* SHA-256 of the controller file that this was made from. */
#define UPPER_SHA256 "@SHA256@"

typedef @REAL@ NAME_real;

/* Which variable-structure law stands between the controller and the amplifier. Any other number: 0 V. */
enum NAME_law {
    UPPER_LAW_NONE = 0,     /* u_c = u */
    UPPER_LAW_SWITCHED = 1, /* u_c = u outside the dead region; inside it u_p sign(e) while the error is large, else 0 */
    UPPER_LAW_INVERSE = 2   /* u_c = u + u_p sat(u/eps_u) */
};

/* Why the rig is held at 0 V. A fault latches until NAME_reset(). */
enum NAME_fault {
    UPPER_FAULT_NONE = 0,
    UPPER_FAULT_DEFLECTION = 1, /* |alpha| beyond deflection_limit_rad */
    UPPER_FAULT_ANGLE = 2,      /* |theta| beyond theta_limit_rad */
    UPPER_FAULT_SPEED = 3,      /* theta moved more than theta_step_limit_rad in one tick */
    UPPER_FAULT_NON_FINITE = 4  /* an input or a result was infinite or not a number */
};

/* How one measurement becomes an angle: y = scale (measured - offset), then y_f += low_pass (y - y_f). */
struct NAME_channel {
    NAME_real scale;      /* correction of the sensor's gain [-] */
    NAME_real offset_rad; /* what the sensor shows at zero [rad] */
    NAME_real low_pass;   /* share of the new measurement, above 0 and at most 1; 1 passes every bit [-] */
};

/* What may change between two ticks, as a whole. Start from NAME_default_settings. A limit that is not a number counts as
 * broken. */
struct NAME_settings {
    struct NAME_channel theta;      /* hub angle */
    struct NAME_channel alpha;      /* deflection angle */
    NAME_real smooth_ticks;         /* duration of the smooth step [ticks]; 0 passes the reference */
    NAME_real smooth_step_rad;      /* steps above this size take proportionally longer [rad] */
    enum NAME_law law;              /* variable-structure law */
    NAME_real u_p_plus_v;           /* compensation voltage, positive direction [V] */
    NAME_real u_p_minus_v;          /* the same in the negative direction, as a magnitude [V] */
    NAME_real eps_u_v;              /* threshold of switch 2, width of the inverse law's ramp [V] */
    NAME_real eps_e_rad;            /* threshold of switch 1 [rad] */
    NAME_real hysteresis_u;         /* switch 2 opens above eps_u (1 + hysteresis_u) [-] */
    NAME_real hysteresis_e;         /* switch 1 opens below eps_e (1 - hysteresis_e) [-] */
    NAME_real breakaway_plus_v;     /* estimated breakaway voltage, positive direction [V] */
    NAME_real breakaway_minus_v;    /* the same in the negative direction, as a magnitude [V] */
    NAME_real voltage_limit_v;      /* largest magnitude of the voltage [V] */
    NAME_real deflection_limit_rad; /* largest |alpha|; beyond it: fault [rad] */
    NAME_real theta_limit_rad;      /* largest |theta|; beyond it: fault [rad] */
    NAME_real theta_step_limit_rad; /* largest change of theta in one tick; beyond it: fault [rad] */
};

/* What one tick is given. */
struct NAME_measured {
    NAME_real reference_rad; /* reference of the tip angle psi = theta + alpha [rad]; may step */
    NAME_real theta_rad;     /* hub angle, counter-clockwise [rad] */
    NAME_real alpha_rad;     /* deflection angle of the tip relative to the hub [rad] */
};

/* What one tick answers. */
struct NAME_commanded {
    NAME_real voltage_v;     /* voltage to send [V] */
    NAME_real u_v;           /* the controller's u, before the law [V] */
    NAME_real reference_rad; /* v, the reference after smoothing [rad] */
    NAME_real y_rad;         /* y = psi, filtered tip angle [rad] */
    NAME_real y_model_rad;   /* output of the reference model [rad] */
    NAME_real error_rad;     /* e = y_model - y [rad] */
    enum NAME_fault fault;   /* why the voltage is zero, if it must be */
};

/* First-order low-pass. */
struct NAME_low_pass {
    NAME_real y_f;
    bool has; /* a measurement has come */
};

/* The smooth step: where the reference is and where it goes. */
struct NAME_path {
    NAME_real target;
    NAME_real position;
    NAME_real velocity;     /* per tick */
    NAME_real acceleration; /* per tick^2 */
    NAME_real c0, c1, c2;
    NAME_real gone;
    NAME_real ticks;
};

/* All that one tick hands to the next. Read fault and the first UPPER_ORDER numbers of z (x); leave the rest alone. */
struct NAME_state {
    NAME_real z[UPPER_ORDER + 3]; /* x, v, y, u_applied */
    NAME_real next[UPPER_ORDER > 0 ? UPPER_ORDER : 1];
    struct NAME_low_pass theta;
    struct NAME_low_pass alpha;
    struct NAME_path reference;
    bool error_is_large;  /* switch 1 */
    bool is_dead;         /* switch 2 */
    enum NAME_fault fault;
};

/* The settings of the controller file. */
extern const struct NAME_settings NAME_default_settings;

/* At rest at 0 rad, x = 0, no fault: before the first tick, and the only way out of a fault. Where the beam rests elsewhere, the
 * channels' offsets take it to 0 rad. */
void NAME_reset(struct NAME_state *state);

/* One period. A missed tick is not made up for: the next one runs with the state as it stands. */
struct NAME_commanded NAME_tick(const struct NAME_settings *settings, struct NAME_state *state,
                                struct NAME_measured measured);

/* Runs a few ticks whose answers are known to the last bit. Returns 0 when all are right; otherwise the number of the first wrong
 * one: the compiler contracts products and sums, or the processor flushes subnormal numbers. Then do not run the controller. */
int NAME_selfcheck(void);

#ifdef __cplusplus
}
#endif

#endif
