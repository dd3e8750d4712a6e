/* The most memory that the process has had in use (Linux, proc(5)). */
#ifndef HPR_APP_MEMORY_PEAK_H
#define HPR_APP_MEMORY_PEAK_H

/* Sets it back to what is in use now; from Linux 4.0 on. */
void hpr_memory_reset_peak(void);

/* Bytes; NaN if the system does not say. */
double hpr_memory_peak(void);

#endif
