/* The controller on a rig behind UDP, without flexbeam: greets the rig, runs it for some seconds, stops it.
 *
 *   main_udp ADDRESS PORT REFERENCE_RAD SECONDS [HOLD_MS] > run.csv
 *
 * The reference is REFERENCE_RAD from the start. HOLD_MS, 50 unless given: how long one voltage may stand without a newer one;
 * so long are missing answers borne, too. Standard output: one line a period. Exit status: 0, ran to the end;
 * 2, usage, no rig, or no clock; 3, a fault stopped it. POSIX; the frames are described in flexbeam's book,
 * "A rig behind UDP or a serial line". A simulated rig to try it on: flexbeam rig --listen udp:127.0.0.1:4810 */
#define _POSIX_C_SOURCE 200809L

#include "NAME.h"
#include "flexbeam_frame.h"

#include <arpa/inet.h>
#include <errno.h>
#include <math.h> /* NAN alone */
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
    HOLD_MS = 50,     /* the rig goes to 0 V by itself when no command came for so long */
    GREETINGS = 50,   /* commands with sequences -50 .. -1 ask whether a rig is there */
    GREETING_MS = 20, /* from one greeting to the next */
    STOPS = 3         /* stop commands at the end: one may be lost */
};

static const long long NS_PER_S = 1000000000LL;

/* One run's talk with its rig. */
struct link {
    int socket;
    uint32_t session;
    uint32_t boots;
    uint16_t hold_ms;
};

enum heard { NOTHING, READINGS, FAULT };

static long long now_ns(void)
{
    struct timespec now;
    if (clock_gettime(CLOCK_MONOTONIC, &now) != 0) {
        perror("main_udp: clock_gettime");
        exit(2);
    }
    return (long long)now.tv_sec * NS_PER_S + now.tv_nsec;
}

static void sleep_until(long long deadline_ns)
{
    const struct timespec deadline = {(time_t)(deadline_ns / NS_PER_S), (long)(deadline_ns % NS_PER_S)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &deadline, NULL) == EINTR) {
    }
}

/* A command that cannot be sent is as one that is lost: the answer that does not come tells. */
static void command(const struct link *link, uint32_t sequence, uint16_t flags, double voltage_v)
{
    const struct flexbeam_command command = {link->session, sequence, link->hold_ms, flags, voltage_v};
    uint8_t frame[FLEXBEAM_COMMAND_BYTES];
    flexbeam_encode_command(&command, frame);
    (void)!send(link->socket, frame, sizeof frame, 0);
}

/* Waits for a frame of this session; nothing comes after the deadline. */
static bool next_frame(const struct link *link, long long deadline_ns, struct flexbeam_measurement *answer)
{
    for (;;) {
        struct pollfd ready = {link->socket, POLLIN, 0};
        const long long left_ns = deadline_ns - now_ns();
        uint8_t frame[FLEXBEAM_LONGEST_FRAME];
        if (left_ns <= 0 || poll(&ready, 1, (int)(left_ns / 1000000LL + 1)) == 0) {
            return false;
        }
        const ssize_t length = recv(link->socket, frame, sizeof frame, MSG_DONTWAIT);
        if (length > 0 && flexbeam_decode_measurement(frame, (size_t)length, answer) == FLEXBEAM_OK &&
            answer->session == link->session) {
            return true;
        }
    }
}

static bool greet(struct link *link)
{
    for (uint32_t left = GREETINGS; left > 0; --left) {
        struct flexbeam_measurement answer;
        command(link, (uint32_t)(0u - left), 0, 0.0);
        const long long deadline_ns = now_ns() + GREETING_MS * 1000000LL;
        if (next_frame(link, deadline_ns, &answer)) {
            link->boots = answer.boots;
            return true;
        }
        sleep_until(deadline_ns); /* a refused datagram answers at once */
    }
    return false;
}

/* The readings that answer the command of this sequence. */
static enum heard hear(const struct link *link, uint32_t sequence, long long deadline_ns,
                       struct NAME_measured *measured)
{
    struct flexbeam_measurement answer;
    while (next_frame(link, deadline_ns, &answer)) {
        if (answer.boots != link->boots || (answer.status & (FLEXBEAM_TIMED_OUT | FLEXBEAM_STOPPED)) != 0) {
            return FAULT;
        }
        if (answer.sequence == sequence) {
            const bool broken = (answer.status & FLEXBEAM_SENSOR_FAULT) != 0;
            measured->theta_rad = broken ? (NAME_real)NAN : (NAME_real)answer.theta_rad;
            measured->alpha_rad = broken ? (NAME_real)NAN : (NAME_real)answer.alpha_rad;
            return READINGS;
        }
    }
    return NOTHING;
}

/* At instant k: send the voltage of tick k - 1, read, tick. Returns whether nothing stopped it. */
static bool run(const struct link *link, NAME_real reference_rad, uint32_t ticks)
{
    static struct NAME_state state;
    struct NAME_measured measured = {reference_rad, 0, 0};
    double voltage_v = 0.0;
    uint32_t lost = 0;
    const uint32_t most_lost = (uint32_t)(link->hold_ms * 0.001 / UPPER_PERIOD_S);
    const long long period_ns = (long long)(UPPER_PERIOD_S * 1e9 + 0.5);
    const long long start_ns = now_ns();
    NAME_reset(&state);
    printf("time_s,reference_rad,theta_rad,alpha_rad,voltage_v,fault\n");
    for (uint32_t k = 0; k < ticks; ++k) {
        const long long deadline_ns = start_ns + (long long)k * period_ns;
        sleep_until(deadline_ns);
        command(link, k, 0, voltage_v);
        const enum heard heard = hear(link, k, deadline_ns + period_ns / 2, &measured);
        lost = heard == NOTHING ? lost + 1 : 0;
        if (heard == FAULT || lost > most_lost) {
            fprintf(stderr, "main_udp: tick %lu: %s\n", (unsigned long)k,
                    heard == FAULT ? "the rig has stopped or restarted" : "the rig does not answer any more");
            return false;
        }
        const struct NAME_commanded commanded = NAME_tick(&NAME_default_settings, &state, measured);
        voltage_v = (double)commanded.voltage_v;
        printf("%.17g,%.17g,%.17g,%.17g,%.17g,%d\n", k * UPPER_PERIOD_S, (double)reference_rad,
               (double)measured.theta_rad, (double)measured.alpha_rad, voltage_v, (int)commanded.fault);
        if (commanded.fault != UPPER_FAULT_NONE) {
            fprintf(stderr, "main_udp: tick %lu: fault %d\n", (unsigned long)k, (int)commanded.fault);
            return false;
        }
    }
    return true;
}

static bool open_link(struct link *link, const char *address, const char *port)
{
    struct sockaddr_in rig;
    memset(&rig, 0, sizeof rig);
    rig.sin_family = AF_INET;
    rig.sin_port = htons((uint16_t)strtoul(port, NULL, 10));
    link->session = (uint32_t)time(NULL) * 2654435761u ^ (uint32_t)getpid();
    link->socket = socket(AF_INET, SOCK_DGRAM, 0);
    return link->socket >= 0 && inet_pton(AF_INET, address, &rig.sin_addr) == 1 &&
           connect(link->socket, (const struct sockaddr *)&rig, sizeof rig) == 0;
}

int main(int count, char **arguments)
{
    struct link link;
    if (count != 5 && count != 6) {
        fprintf(stderr, "usage: main_udp ADDRESS PORT REFERENCE_RAD SECONDS [HOLD_MS]\n");
        return 2;
    }
    const unsigned long hold_ms = count == 6 ? strtoul(arguments[5], NULL, 10) : HOLD_MS;
    if (hold_ms == 0 || hold_ms > UINT16_MAX) {
        fprintf(stderr, "main_udp: found a hold of %s ms, needed 1 to 65535\n", arguments[5]);
        return 2;
    }
    link.hold_ms = (uint16_t)hold_ms;
    const double reference_rad = strtod(arguments[3], NULL);
    const double seconds = strtod(arguments[4], NULL);
    if (!(seconds > 0.0 && seconds / UPPER_PERIOD_S < 2147483647.0)) {
        fprintf(stderr, "main_udp: found %s seconds, needed a positive number\n", arguments[4]);
        return 2;
    }
    if (NAME_selfcheck() != 0) {
        fprintf(stderr, "main_udp: this build does not compute what flexbeam computes; see NAME_selfcheck()\n");
        return 2;
    }
    if (!open_link(&link, arguments[1], arguments[2]) || !greet(&link)) {
        fprintf(stderr, "main_udp: no rig answers at %s port %s\n", arguments[1], arguments[2]);
        return 2;
    }
    const bool ended_well = run(&link, (NAME_real)reference_rad, (uint32_t)(seconds / UPPER_PERIOD_S + 0.5));
    for (int k = 0; k < STOPS; ++k) {
        command(&link, 0, FLEXBEAM_STOP, 0.0);
    }
    close(link.socket);
    return ended_well ? 0 : 3;
}
