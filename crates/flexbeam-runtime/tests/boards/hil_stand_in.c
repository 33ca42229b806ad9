/* A stand-in for Quanser's HIL library with one card, "q2_usb" "0": the calls that flexbeam makes, with the meaning that
 * hil.h gives them. Written from the documentation; it shows that flexbeam keeps to that, not that a board does.
 *
 * The card has 2 analogue outputs and inputs, 2 encoders, 8 digital lines, and a watchdog that expires by wall time. Once
 * expired the outputs stand at the expiration state and every access is refused until the watchdog is cleared; clearing
 * brings back the voltages of before, the worst that "restores the state prior to the expiry" can mean. The rig behind it
 * moves ten counts for each volt at each reading.
 *
 * Functions that begin with stand_in_ are the tests' own. */

#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

typedef struct tag_card { int open; } *t_card;

enum { OUTPUTS = 2, INPUTS = 2, ENCODERS = 2, LINES = 8 };
enum { BAD_HANDLE = -101, NO_BOARD = -102, BAD_CHANNEL = -103, PROTECTED = -104, BAD_ARGUMENT = -105, IN_USE = -106 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t released = PTHREAD_COND_INITIALIZER;
static struct tag_card the_card;
static double written_v[OUTPUTS], expiration_v[OUTPUTS], gauge_v;
static int counts[ENCODERS];
static int has_watchdog = 1, running, expired;
static double timeout_s, reloaded_s;
static char log_path[4096], failing[64], stalling[64];
static int failing_in, failing_code, stalling_in;

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void note(const char *line)
{
    if (log_path[0] == 0) return;
    FILE *file = fopen(log_path, "a");
    fprintf(file, "%s\n", line);
    fclose(file);
}

static void settle(void)
{
    if (running && !expired && now_s() - reloaded_s > timeout_s) expired = 1;
}

/* Every call begins here, with the lock held: 0, or the code with which it is to fail. */
static int begin(t_card card, const char *call, const char *line)
{
    note(line);
    if (strcmp(call, stalling) == 0 && --stalling_in == 0) {
        while (stalling[0] != 0) pthread_cond_wait(&released, &lock);
    }
    settle();
    if (card != &the_card || !the_card.open) return BAD_HANDLE;
    if (strcmp(call, failing) == 0 && --failing_in == 0) return failing_code;
    return 0;
}

static int outside(const unsigned channels[], unsigned n, unsigned limit)
{
    for (unsigned k = 0; k < n; k++)
        if (channels[k] >= limit) return 1;
    return 0;
}

int hil_open(const char *type, const char *identifier, t_card *card)
{
    char line[256];
    snprintf(line, sizeof line, "hil_open %s %s", type, identifier);
    pthread_mutex_lock(&lock);
    note(line);
    int code = strcmp(type, "q2_usb") || strcmp(identifier, "0") ? NO_BOARD : the_card.open ? IN_USE : 0;
    if (code == 0) {
        the_card.open = 1;
        *card = &the_card;
    }
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_close(t_card card)
{
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_close", "hil_close");
    if (code == 0) the_card.open = 0;
    pthread_mutex_unlock(&lock);
    return code;
}

static int write_outputs(const unsigned channels[], unsigned n, const double volts[])
{
    if (outside(channels, n, OUTPUTS)) return BAD_CHANNEL;
    if (expired) return PROTECTED;
    for (unsigned k = 0; k < n; k++) written_v[channels[k]] = volts[k];
    return 0;
}

int hil_write_analog(t_card card, const unsigned channels[], unsigned n, const double volts[])
{
    char line[256];
    snprintf(line, sizeof line, "hil_write_analog %u:%g", channels[0], volts[0]);
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_write_analog", line);
    if (code == 0) code = write_outputs(channels, n, volts);
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_read_write(t_card card, const unsigned ai[], unsigned n_ai, const unsigned ei[], unsigned n_ei,
                   const unsigned di[], unsigned n_di, const unsigned oi[], unsigned n_oi, const unsigned ao[],
                   unsigned n_ao, const unsigned po[], unsigned n_po, const unsigned d_o[], unsigned n_do,
                   const unsigned oo[], unsigned n_oo, double analog[], int encoder[], char digital[], double other[],
                   const double analog_out[], const double pwm_out[], const char digital_out[], const double other_out[])
{
    char line[256];
    snprintf(line, sizeof line, "hil_read_write %u:%g", ao[0], analog_out[0]);
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_read_write", line);
    int unused = n_di || n_oi || n_po || n_do || n_oo || di || oi || po || d_o || oo || digital || other || pwm_out
                 || digital_out || other_out;
    if (code == 0 && unused) code = BAD_ARGUMENT;
    if (code == 0 && (outside(ai, n_ai, INPUTS) || outside(ei, n_ei, ENCODERS))) code = BAD_CHANNEL;
    if (code == 0) code = write_outputs(ao, n_ao, analog_out);
    if (code == 0) {
        for (unsigned k = 0; k < n_ai; k++) analog[k] = gauge_v;
        for (unsigned k = 0; k < n_ei; k++) {
            encoder[k] = counts[ei[k]];
            counts[ei[k]] = (int)((unsigned)counts[ei[k]] + (unsigned)(int)(10.0 * written_v[ao[0]]));
        }
    }
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_set_encoder_counts(t_card card, const unsigned channels[], unsigned n, const int values[])
{
    char line[256];
    snprintf(line, sizeof line, "hil_set_encoder_counts %u:%d", channels[0], values[0]);
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_set_encoder_counts", line);
    if (code == 0 && outside(channels, n, ENCODERS)) code = BAD_CHANNEL;
    if (code == 0 && expired) code = PROTECTED;
    if (code == 0)
        for (unsigned k = 0; k < n; k++) counts[channels[k]] = values[k];
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_watchdog_set_analog_expiration_state(t_card card, const unsigned channels[], unsigned n, const double volts[])
{
    char line[256];
    snprintf(line, sizeof line, "hil_watchdog_set_analog_expiration_state %u:%g", channels[0], volts[0]);
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_watchdog_set_analog_expiration_state", line);
    if (code == 0 && outside(channels, n, OUTPUTS)) code = BAD_CHANNEL;
    if (code == 0 && running) code = BAD_ARGUMENT;
    if (code == 0)
        for (unsigned k = 0; k < n; k++) expiration_v[channels[k]] = volts[k];
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_watchdog_set_digital_expiration_state(t_card card, const unsigned channels[], unsigned n, const int states[])
{
    char line[256];
    snprintf(line, sizeof line, "hil_watchdog_set_digital_expiration_state %u..%u:%d", channels[0], channels[n - 1],
             states[n - 1]);
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_watchdog_set_digital_expiration_state", line);
    if (code == 0 && outside(channels, n, LINES)) code = BAD_CHANNEL;
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_watchdog_start(t_card card, double timeout)
{
    char line[256];
    snprintf(line, sizeof line, "hil_watchdog_start %g", timeout);
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_watchdog_start", line);
    if (code == 0 && (!has_watchdog || !(timeout > 0.0) || running)) code = BAD_ARGUMENT;
    if (code == 0) {
        running = 1;
        timeout_s = timeout;
        reloaded_s = now_s();
    }
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_watchdog_reload(t_card card)
{
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_watchdog_reload", "hil_watchdog_reload");
    if (code == 0) {
        code = running && !expired;
        reloaded_s = now_s();
    }
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_watchdog_is_expired(t_card card)
{
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_watchdog_is_expired", "hil_watchdog_is_expired");
    if (code == 0) code = has_watchdog ? expired : BAD_ARGUMENT;
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_watchdog_stop(t_card card)
{
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_watchdog_stop", "hil_watchdog_stop");
    if (code == 0) running = 0;
    pthread_mutex_unlock(&lock);
    return code;
}

int hil_watchdog_clear(t_card card)
{
    pthread_mutex_lock(&lock);
    int code = begin(card, "hil_watchdog_clear", "hil_watchdog_clear");
    if (code == 0) expired = 0;
    pthread_mutex_unlock(&lock);
    return code;
}

int msg_get_error_messageA(const char *locale, int code, char *buffer, size_t length)
{
    static const char *const texts[] = { "The handle is not that of an open card.", "No such board was found.",
                                         "The board has no such channel.", "The watchdog has closed the board.",
                                         "An argument is out of its range.", "The board is in use." };
    int k = BAD_HANDLE - code;
    if (locale != NULL || k < 0 || k >= (int)(sizeof texts / sizeof texts[0])) return -1;
    snprintf(buffer, length, "%s", texts[k]);
    return 0;
}

void stand_in_log_path(const char *path) { snprintf(log_path, sizeof log_path, "%s", path); }

/* The nth call of this name from now on fails with this code. */
void stand_in_fail(const char *call, int nth, int code)
{
    pthread_mutex_lock(&lock);
    snprintf(failing, sizeof failing, "%s", call);
    failing_in = nth;
    failing_code = code;
    pthread_mutex_unlock(&lock);
}

/* The nth call of this name from now on hangs until it is released. */
void stand_in_stall(const char *call, int nth)
{
    pthread_mutex_lock(&lock);
    snprintf(stalling, sizeof stalling, "%s", call);
    stalling_in = nth;
    pthread_mutex_unlock(&lock);
}

void stand_in_release(void)
{
    pthread_mutex_lock(&lock);
    stalling[0] = 0;
    pthread_cond_broadcast(&released);
    pthread_mutex_unlock(&lock);
}

void stand_in_sensors(int count, double volts)
{
    pthread_mutex_lock(&lock);
    counts[0] = counts[1] = count;
    gauge_v = volts;
    pthread_mutex_unlock(&lock);
}

/* What stands at the terminals now. */
double stand_in_output_v(void)
{
    pthread_mutex_lock(&lock);
    settle();
    double volts = expired ? expiration_v[0] : written_v[0];
    pthread_mutex_unlock(&lock);
    return volts;
}

int stand_in_open_handles(void) { return the_card.open; }

void stand_in_without_watchdog(void) { has_watchdog = 0; }

/* The watchdog expires now; this voltage was the last one written. */
void stand_in_expired_at(double volts)
{
    pthread_mutex_lock(&lock);
    written_v[0] = volts;
    running = expired = 1;
    pthread_mutex_unlock(&lock);
}
