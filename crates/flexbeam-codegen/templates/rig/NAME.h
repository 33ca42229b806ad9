/* @TITLE@
 *
@BANNER@
 *
 * Once a period: NAME_measure() reads the sensors at the sample instant, NAME_apply() holds a voltage until the next one. Both
 * allocate nothing, call nothing of libm and keep nothing but the state that their caller owns.
 *
 * theta: hub angle, counter-clockwise; alpha: deflection angle of the tip relative to the hub; psi = theta + alpha: tip angle.
 *
 * C99, IEEE 754 arithmetic. Build with -ffp-contract=off and without -ffast-math: then the answers have the same bits on every
 * machine. NAME_selfcheck() finds a compiler or a processor that computes otherwise; call it once at start. */
#ifndef UPPER_H
#define UPPER_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Number of states of hub and link: [theta theta' eta eta']. */
#define UPPER_ORDER @ORDER@

/* Sample period [s]: how long NAME_apply() holds a voltage. */
#define UPPER_PERIOD_S @PERIOD@

/* SHA-256 of all numbers of this rig. */
#define UPPER_SHA256 "@SHA256@"

/* Which of three sets of linear equations the hub obeys. */
enum NAME_contact {
    UPPER_CONTACT_FREE = 0,   /* there is no dry friction */
    UPPER_CONTACT_STUCK = 1,  /* dry friction holds the hub: theta' = 0 to the last bit */
    UPPER_CONTACT_SLIDING = 2 /* dry friction opposes the hub's speed */
};

/* What a commanded voltage becomes: conversion, saturation, dead zone. */
struct NAME_actuator {
    double converter_step_v;  /* resolution of the converter [V]; 0: exact */
    double limit_v;           /* largest magnitude that the amplifier gives [V] */
    double dead_zone_plus_v;  /* positive voltage that is lost before any torque appears [V] */
    double dead_zone_minus_v; /* the same in the negative direction, as a magnitude [V] */
};

/* tau(theta') = coulomb + stribeck_extra exp(-(theta'/stribeck_speed)^2). Not to be changed but before NAME_reset(). */
struct NAME_friction {
    double coulomb_nm;           /* torque that opposes a sliding hub at speed [N m] */
    double stribeck_extra_nm;    /* what the breakaway torque exceeds it by [N m]; 0: no Stribeck effect */
    double stribeck_speed_rad_s; /* speed at which the excess has fallen to 1/e [rad/s] */
};

/* Encoder on the load shaft. */
struct NAME_encoder {
    uint32_t counts_per_turn; /* 0: exact */
};

/* Strain gauge and its converter, referred to the deflection angle. */
struct NAME_gauge {
    double noise_rad;          /* standard deviation of white Gaussian noise [rad] */
    double bias_rad;           /* what it reads at alpha = 0 [rad] */
    double converter_step_rad; /* resolution of the converter [rad]; 0: exact */
};

/* Start from NAME_default_parameters. */
struct NAME_parameters {
    struct NAME_actuator actuator;
    struct NAME_friction friction;
    struct NAME_encoder encoder;
    struct NAME_gauge gauge;
};

/* What the control computer reads at a sample instant. */
struct NAME_measurement {
    double theta_rad; /* hub angle as counted [rad] */
    double alpha_rad; /* deflection angle as the gauge reads it [rad] */
};

/* What nobody can read on a real rig. */
struct NAME_truth {
    double theta_rad;          /* hub angle [rad] */
    double alpha_rad;          /* deflection angle of the tip [rad] */
    double psi_rad;            /* tip angle [rad] */
    double theta_rad_s;        /* hub speed [rad/s] */
    double alpha_rad_s;        /* speed of the deflection angle [rad/s] */
    enum NAME_contact contact; /* of the hub */
};

/* Where in the sequence of a seed the noise is. */
struct NAME_noise {
    uint64_t seed;
    uint64_t drawn;     /* words of 64 bits since the beginning */
    uint32_t block[16]; /* those that stand ready */
};

/* All that one period hands to the next. Leave it alone. */
struct NAME_state {
    double x[UPPER_ORDER];
    double next[UPPER_ORDER];
    enum NAME_contact contact;
    double direction; /* in which the hub slides: 1 or -1 */
    struct NAME_noise noise;
};

/* Those of the rig that this was made from. */
extern const struct NAME_parameters NAME_default_parameters;

/* At rest at theta = alpha = 0; the seed decides the sensor noise. */
void NAME_reset(const struct NAME_parameters *parameters, struct NAME_state *state, uint64_t seed);

/* The sensors at this instant. Each call draws new noise. */
struct NAME_measurement NAME_measure(const struct NAME_parameters *parameters, struct NAME_state *state);

/* Holds the commanded voltage for one period. What is not a number counts as 0 V. */
void NAME_apply(const struct NAME_parameters *parameters, struct NAME_state *state, double commanded_v);

/* The state behind the sensors. */
struct NAME_truth NAME_truth(const struct NAME_state *state);

/* Brings the noise to the place in its sequence that seed and drawn name. */
void NAME_noise_recall(struct NAME_noise *noise, uint64_t seed, uint64_t drawn);

/* Runs a few periods whose answers are known to the last bit. Returns 0 when all are right; otherwise the number of the first
 * wrong one: the compiler contracts products and sums, or the processor flushes subnormal numbers. */
int NAME_selfcheck(void);

#ifdef __cplusplus
}
#endif

#endif
