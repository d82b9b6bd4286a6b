/* SPDX-License-Identifier: GPL-3.0-or-later
 * Clocks. */
#if !defined(_WIN32)
#define _POSIX_C_SOURCE 200809L
#endif
#include "base/timer.h"

#if defined(_WIN32)
#include <windows.h>

static double filetime_seconds(FILETIME a) {
    return 1e-7 * ((double)a.dwHighDateTime * 4294967296.0 + (double)a.dwLowDateTime);
}

double enf_wall_seconds(void) {
    LARGE_INTEGER now, rate;
    QueryPerformanceCounter(&now);
    QueryPerformanceFrequency(&rate);
    return (double)now.QuadPart / (double)rate.QuadPart;
}

double enf_cpu_seconds(void) {
    FILETIME made, ended, kernel, user;
    if (!GetProcessTimes(GetCurrentProcess(), &made, &ended, &kernel, &user))
        return 0.0;
    return filetime_seconds(kernel) + filetime_seconds(user);
}

double enf_thread_cpu_seconds(void) {
    FILETIME made, ended, kernel, user;
    if (!GetThreadTimes(GetCurrentThread(), &made, &ended, &kernel, &user))
        return 0.0;
    return filetime_seconds(kernel) + filetime_seconds(user);
}

void enf_sleep_seconds(double seconds) {
    Sleep((DWORD)(seconds > 0 ? 1000 * seconds + 0.5 : 0));
}
#else
#include <time.h>

static double clock_seconds(clockid_t clock) {
    struct timespec now;
    if (clock_gettime(clock, &now) != 0)
        return 0.0;
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double enf_wall_seconds(void) {
    return clock_seconds(CLOCK_MONOTONIC);
}
double enf_cpu_seconds(void) {
    return clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
}
double enf_thread_cpu_seconds(void) {
    return clock_seconds(CLOCK_THREAD_CPUTIME_ID);
}

void enf_sleep_seconds(double seconds) {
    if (!(seconds > 0))
        return;
    struct timespec span = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
    nanosleep(&span, NULL);
}
#endif
