/* The one way in which the loop refuses to start: a line on standard error, exit code 2. */
#ifndef ERC_FAIL_H
#define ERC_FAIL_H

_Noreturn void erc_fail(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
