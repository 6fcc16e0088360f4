/* A host of FMI 3.0 FMUs with nothing but dlopen: rows of inputs (hex floats) in, effort and flags out.
   host LIBRARY TOKEN exchange|simulate PERIOD INPUTS */
#include <dlfcn.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef void (*log_message)(void *, int, const char *, const char *);

static void say(void *environment, int status, const char *category, const char *message)
{
    (void)environment;
    fprintf(stderr, "%d %s: %s\n", status, category, message);
}

static void *library;

static void *find(const char *name)
{
    void *found = dlsym(library, name);
    if (found == NULL)
    {
        fprintf(stderr, "no %s\n", name);
        exit(2);
    }
    return found;
}

/* POSIX lets a pointer to data hold one to a function. */
#define FUNCTION(type, name, ...)                                                                                      \
    type (*name)(__VA_ARGS__);                                                                                         \
    *(void **)&name = find(#name)

int main(int count, char **words)
{
    double values[64];
    uint32_t references[64];
    size_t inputs, i;
    double period;
    long k = 0;
    bool exchange, flag, event, stop, early;
    void *fmu;
    if (count != 6 || (library = dlopen(words[1], RTLD_NOW)) == NULL)
    {
        fprintf(stderr, "%s\n", (count == 6) ? dlerror() : "five arguments");
        return 2;
    }
    exchange = strcmp(words[3], "exchange") == 0;
    period = atof(words[4]);
    inputs = (size_t)atoi(words[5]);
    FUNCTION(void *, fmi3InstantiateModelExchange, const char *, const char *, const char *, bool, bool, void *,
             log_message);
    FUNCTION(void *, fmi3InstantiateCoSimulation, const char *, const char *, const char *, bool, bool, bool, bool,
             const uint32_t *, size_t, void *, log_message, void *);
    FUNCTION(int, fmi3EnterInitializationMode, void *, bool, double, double, bool, double);
    FUNCTION(int, fmi3ExitInitializationMode, void *);
    FUNCTION(int, fmi3EnterEventMode, void *);
    FUNCTION(int, fmi3SetTime, void *, double);
    FUNCTION(int, fmi3UpdateDiscreteStates, void *, bool *, bool *, bool *, bool *, bool *, double *);
    FUNCTION(int, fmi3EnterContinuousTimeMode, void *);
    FUNCTION(int, fmi3SetFloat64, void *, const uint32_t *, size_t, const double *, size_t);
    FUNCTION(int, fmi3GetFloat64, void *, const uint32_t *, size_t, double *, size_t);
    FUNCTION(int, fmi3GetUInt32, void *, const uint32_t *, size_t, uint32_t *, size_t);
    FUNCTION(int, fmi3DoStep, void *, double, double, bool, bool *, bool *, bool *, double *);
    FUNCTION(void, fmi3FreeInstance, void *);
    if (exchange ? fmi3InstantiateModelExchange("x", "wrong", NULL, false, false, NULL, NULL) != NULL
                 : fmi3InstantiateCoSimulation("x", "wrong", NULL, false, false, false, false, NULL, 0u, NULL, NULL,
                                               NULL) != NULL)
    {
        fprintf(stderr, "a wrong token is taken\n");
        return 1;
    }
    fmu = exchange ? fmi3InstantiateModelExchange("x", words[2], NULL, false, false, NULL, say)
                   : fmi3InstantiateCoSimulation("x", words[2], NULL, false, false, false, false, NULL, 0u, NULL, say,
                                                 NULL);
    if (fmu == NULL || fmi3EnterInitializationMode(fmu, false, 0.0, 0.0, false, 0.0) != 0 ||
        fmi3ExitInitializationMode(fmu) != 0)
    {
        return 1;
    }
    for (i = 0u; i < inputs; i++)
    {
        references[i] = (uint32_t)i + 1u;
    }
    for (;; k++)
    {
        const uint32_t effort_at = (uint32_t)inputs + 1u, flags_at = (uint32_t)inputs + 2u;
        double effort, next;
        uint32_t flags;
        int bad = 0;
        for (i = 0u; i < inputs; i++)
        {
            if (scanf("%lf", &values[i]) != 1)
            {
                fmi3FreeInstance(fmu);
                return 0;
            }
        }
        if (exchange)
        {
            bad |= fmi3SetTime(fmu, (double)k * period) | fmi3EnterEventMode(fmu);
            bad |= fmi3SetFloat64(fmu, references, inputs, values, inputs);
            bad |= fmi3UpdateDiscreteStates(fmu, &flag, &stop, &event, &early, &flag, &next);
            bad |= fmi3EnterContinuousTimeMode(fmu);
        }
        else
        {
            bad |= fmi3SetFloat64(fmu, references, inputs, values, inputs);
            bad |= fmi3DoStep(fmu, (double)k * period, period, true, &event, &stop, &early, &next);
        }
        bad |= fmi3GetFloat64(fmu, &effort_at, 1u, &effort, 1u) | fmi3GetUInt32(fmu, &flags_at, 1u, &flags, 1u);
        if (bad)
        {
            return 1;
        }
        printf("%a %u\n", effort, flags);
    }
}
