/* A step as a function of Python: one call of the interpreter's own protocol in place of ctypes' conversions. Needs no
   headers of Python; all of this is in its stable ABI (3.10 and later). */
#include <stddef.h>
#include <stdint.h>

typedef struct erc_object erc_object;
extern double PyFloat_AsDouble(erc_object *);
extern erc_object *PyFloat_FromDouble(double);
extern erc_object *PyErr_Occurred(void);
extern void PyErr_SetString(erc_object *, const char *);
extern void *PyLong_AsVoidPtr(erc_object *);
extern erc_object *PyExc_TypeError;

#define MOST 512

typedef struct
{
    uint32_t (*step)(void *, const double *, double *);
    void *state;
    uint32_t inputs;
    uint32_t flags;
} erc_call;

#if !defined(_WIN32)
__attribute__((visibility("default")))
#else
__declspec(dllexport)
#endif
erc_object *erc_python_step(erc_object *self, erc_object *const *arguments, ptrdiff_t count);

erc_object *erc_python_step(erc_object *self, erc_object *const *arguments, ptrdiff_t count)
{
    erc_call *const call = (erc_call *)PyLong_AsVoidPtr(self);
    double in[MOST];
    double effort;
    ptrdiff_t i;
    if (count != (ptrdiff_t)call->inputs || count > MOST)
    {
        PyErr_SetString(PyExc_TypeError, "step takes one number an input: see the model's inputs");
        return NULL;
    }
    for (i = 0; i < count; i++)
    {
        in[i] = PyFloat_AsDouble(arguments[i]);
        if (in[i] == -1.0 && PyErr_Occurred() != NULL)
        {
            return NULL;
        }
    }
    call->flags = call->step(call->state, in, &effort);
    return PyFloat_FromDouble(effort);
}
