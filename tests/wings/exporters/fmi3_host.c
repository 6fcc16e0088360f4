/* A host of FMI 3.0 FMUs with nothing but dlopen, or LoadLibrary: rows of inputs in, effort and flags out, as doubles.
   host LIBRARY TOKEN exchange|simulate PERIOD INPUTS ROWS RESULTS */
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
void *LoadLibraryA(const char *name);
void *GetProcAddress(void *library, const char *name);
int __getmainargs(int *count, char ***words, char ***environment, int wildcards, int *mode);
#define open_library(name) LoadLibraryA(name)
#define find_symbol(library, name) GetProcAddress(library, name)

/* What is called main is compiled with a call to a C runtime, and here is none. */
#define main host
int main(int count, char **words);

void start(void)
{
    int count, mode = 0;
    char **words, **environment;
    __getmainargs(&count, &words, &environment, 0, &mode);
    exit(main(count, words));
}
#else
#include <dlfcn.h>
#define open_library(name) dlopen(name, RTLD_NOW)
#define find_symbol(library, name) dlsym(library, name)
#endif

typedef void (*log_message)(void *, int, const char *, const char *);

static void say(void *environment, int status, const char *category, const char *message)
{
    (void)environment;
    (void)status;
    (void)category;
    puts(message);
}

static void *library;

static void *find(const char *name)
{
    void *found = find_symbol(library, name);
    if (found == NULL)
    {
        puts(name);
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
    FILE *rows, *results;
    if (count != 8 || (library = open_library(words[1])) == NULL || (rows = fopen(words[6], "rb")) == NULL ||
        (results = fopen(words[7], "wb")) == NULL)
    {
        puts("seven arguments: a library that loads, and files");
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
        puts("a wrong token is taken");
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
        if (fread(values, sizeof values[0], inputs, rows) != inputs)
        {
            fmi3FreeInstance(fmu);
            return fclose(results);
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
        values[0] = effort;
        values[1] = (double)flags;
        if (fwrite(values, sizeof values[0], 2u, results) != 2u)
        {
            return 1;
        }
    }
}
