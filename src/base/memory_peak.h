/* The most memory that the process has had in use (Linux, proc(5)). getrusage would tell that of the process
   that called exec, if that was larger. */
#ifndef HPR_BASE_MEMORY_PEAK_H
#define HPR_BASE_MEMORY_PEAK_H

/* Sets it back to what is in use now; from Linux 4.0 on. */
void hpr_memory_reset_peak(void);

/* Bytes; NaN if the system does not say. */
double hpr_memory_peak(void);

#endif
