/* SPDX-License-Identifier: GPL-3.0-or-later
 * Clocks. */
#ifndef ENF_BASE_TIMER_H
#define ENF_BASE_TIMER_H

/* Seconds of a clock that never goes back; only differences mean something. Thread-safe. */
double enf_wall_seconds(void);
/* Processor seconds of this process (all threads) / of this thread. Thread-safe. */
double enf_cpu_seconds(void);
double enf_thread_cpu_seconds(void);
/* Gives the processor away for about that long. Thread-safe. */
void enf_sleep_seconds(double seconds);

#endif
