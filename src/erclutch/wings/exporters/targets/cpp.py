"""Target cpp wraps the C files in a C++11 class, for plain C++ and for ROS 2 (CMake, package.xml)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from erclutch._version import __version__
from erclutch.errors import ExportError
from erclutch.export.c.compilers import EXACT, cpp_compilers, native, run
from erclutch.export.c.include_guard import once
from erclutch.export.c_names import KEYWORDS
from erclutch.export.encode import comment, markup
from erclutch.export.exported_step import ExportedStep
from erclutch.export.step_vectors import vectors_of
from erclutch.export.target_check import Check, compare
from erclutch.export.targets import c
from erclutch.files import scratch_folder

TITLE = "a C++11 class around the C step, with CMakeLists.txt and package.xml for ROS 2"
ALARMS = True


def write(step: ExportedStep, folder: Path) -> None:
    """A folder that is a CMake project and an ament_cmake package."""
    n = step.name
    include = folder / "include" / n
    code = folder / "src"
    include.mkdir(parents=True)
    code.mkdir()
    c.write_core(step, code)
    (code / f"{n}.h").rename(include / f"{n}.h")
    cmake = f"""cmake_minimum_required(VERSION 3.16)
project({n} LANGUAGES C CXX)

# Plain CMake: add_subdirectory(...), then target_link_libraries(mine {n}). ROS 2: colcon build takes it as a package.
add_library({n} STATIC src/{n}.c)
target_include_directories({n} PUBLIC
  $<BUILD_INTERFACE:${{CMAKE_CURRENT_SOURCE_DIR}}/include> $<INSTALL_INTERFACE:include>)
target_include_directories({n} PRIVATE include/{n})
set_target_properties({n} PROPERTIES C_STANDARD 99 C_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
target_compile_options({n} PRIVATE $<$<C_COMPILER_ID:GNU,Clang,AppleClang>:-ffp-contract=off>)

add_executable({n}_check src/{n}_check.cpp)
target_compile_features({n}_check PRIVATE cxx_std_11)
target_link_libraries({n}_check {n})
enable_testing()
add_test(NAME {n}_check COMMAND {n}_check)

find_package(ament_cmake QUIET)
if(ament_cmake_FOUND)
  install(TARGETS {n} EXPORT {n}Targets ARCHIVE DESTINATION lib)
  install(DIRECTORY include/ DESTINATION include)
  ament_export_targets({n}Targets HAS_LIBRARY_TARGET)
  ament_package()
endif()
"""
    package = f"""<?xml version="1.0"?>
<package format="3">
  <name>{step.name.lower()}</name>
  <version>{__version__}</version>
  <description>Torque model {markup(step.model.name)}, {step.digest}</description>
  <!-- Fill in the two lines below: nobody but you can say who keeps this package, and under which terms. -->
  <maintainer email="todo@todo.todo">TODO: your name</maintainer>
  <license>TODO: your licence</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""
    texts = {
        include / f"{n}.hpp": _class(step),
        include / f"{n}_vectors.h": c.vectors_header(step, vectors_of(step)),
        code / f"{n}_check.cpp": _check(step),
        folder / "CMakeLists.txt": cmake,
        folder / "package.xml": package,
    }
    for path, text in texts.items():
        path.write_text(text, encoding="ascii")


def class_name(step: ExportedStep) -> str:
    """The class: hem_rise_fall -> HemRiseFall."""
    words = step.name.split("_")
    return "".join(word[:1].upper() + word[1:] for word in words)


def _members(step: ExportedStep) -> list[str]:
    """Names of inputs as members; an input whose name will not do is called by its place."""
    members: list[str] = []
    tidy_names: list[str] = []
    for name in step.inputs:
        without_signs = re.sub(r"\W+", "_", name, flags=re.ASCII)
        tidy_names.append(without_signs.strip("_").lower())
    for i, name in enumerate(tidy_names):
        first = tidy_names.index(name) == i
        good = first and name[:1].isalpha() and name not in KEYWORDS
        members.append(name if good else f"input{i}")
    return members


def _class(step: ExportedStep) -> str:
    n = step.name
    N = step.name.upper()
    members = _members(step)
    lines: list[str] = []
    for member, name, unit in zip(members, step.inputs, step.units, strict=True):
        lines.append(f"    Real {member}{{}};  ///< {comment(f'{name} [{unit}]')}")
    fields = "\n".join(lines)
    unit = comment(step.model.units.effort or "1")
    head = f"""// {step.headline} as a C++ class. Written by erclutch {__version__}.
// Model {step.digest}; {n}.h says more of units and ranges. No allocation, no exceptions, no locks: fit for a
// real-time loop. One object a device; an object is used by one thread at a time.
"""
    declared = f"""// Model {step.digest}
#include <cstdint>

#include "{n}/{n}.h"

namespace {n}_model {{

using Real = {n}_real;

/// One sample.
struct Input {{
{fields}
}};

/// Result of a step or of the steady effort.
struct Output {{
    Real effort;          ///< [{unit}], always finite
    std::uint32_t flags;  ///< {N}_OUTSIDE_RANGE and the like

    bool ok() const noexcept {{ return flags == 0u; }}
}};

/// Result of the inverse.
struct Command {{
    Real field;           ///< signed field{", E1 - E2" if step.elements == 2 else ""}
    std::uint32_t flags;

    bool ok() const noexcept {{ return flags == 0u; }}
}};

{_device(step, members)}
}}  // namespace {n}_model
"""
    return head + once(f"{N}_HPP", declared)


def _device(step: ExportedStep, members: Sequence[str]) -> str:
    """The class of a device: its methods, and the ends of the band where the C keeps them."""
    n = step.name
    name = class_name(step)
    listed = ", ".join(f"in.{member}" for member in members)
    period = "0" if step.period is None else repr(step.period)
    methods = (
        ("One sample.", "Output step(const Input &in)", f"{n}_step(&state_, values, &out.effort)"),
        (
            "The effort once the fluid has settled. Takes speeds.",
            "static Output steady(const Input &in)",
            f"{n}_steady(values, &out.effort)",
        ),
        (
            "The field whose settled effort is the wanted one; the fields in the input do not matter. Takes speeds.",
            "static Command inverse(const Input &in, Real wanted)",
            f"{n}_inverse(values, wanted, &out.field)",
        ),
        (
            "The field that makes the effort of the next step the wanted one; the state stays as it is.",
            "Command inverse_now(const Input &in, Real wanted) const",
            f"{n}_inverse_now(&state_, values, wanted, &out.field)",
        ),
    )
    calls = "\n".join(
        f"""    /// {about}
    {signature} noexcept {{
        const Real values[{n.upper()}_INPUTS] = {{{listed}}};
        {"Command" if "Command" in signature else "Output"} out{{}};
        out.flags = {call};
        return out;
    }}
"""
        for about, signature, call in methods
    )
    band = ""
    if step.alarms:
        for end in ("low", "high"):
            band += f"""    /// {end.capitalize()} end of the band around the effort of the last step.
    Real {end}() const noexcept {{ return state_.{end}; }}

"""
    return f"""class {name} {{
public:
    /// Sampling period in s that the step is made for; 0 where it does not matter.
    static constexpr double period = {period};

    {name}() noexcept {{ reset(); }}

    /// Forget all earlier samples.
    void reset() noexcept {{ (void){n}_reset(&state_); }}

    /// Whether the compiler kept the arithmetic of the C; else every effort and field is 0, with a flag.
    bool exact() const noexcept {{ return state_.exact != 0u; }}

{calls}
{band}    static const char *digest() noexcept {{ return {n.upper()}_DIGEST; }}
    static const char *model() noexcept {{ return {n.upper()}_MODEL; }}

private:
    {n}_state state_;
}};
"""


def _check(step: ExportedStep) -> str:
    n = step.name
    N = step.name.upper()
    p = step.precision
    form = "PRIx32" if p.width == 32 else "PRIx64"
    given = "\n".join(f"    in.{m} = number(row[{i}]);" for i, m in enumerate(_members(step)))
    return f"""// Prints the bits of every result of the test vectors; exit code 0 if all are as expected.
#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "{n}/{n}.hpp"
#include "{n}/{n}_vectors.h"

using Word = {p.c_bits};
using namespace {n}_model;

static Real number(Word bits) {{
    Real x;
    std::memcpy(&x, &bits, sizeof x);
    return x;
}}

static bool show(Real x, std::uint32_t flags, Word expected, std::uint32_t expected_flags) {{
    Word bits;
    std::memcpy(&bits, &x, sizeof bits);
    std::printf("%" {form} " %" PRIu32 "\\n", bits, flags);
    return bits == expected && flags == expected_flags;
}}

static Input input(const Word *row) {{
    Input in;
{given}
    return in;
}}

int main() {{
    {class_name(step)} device;
    bool good = device.exact();
    for (unsigned i = 0; i < STEPS; i++) {{
        const Output out = device.step(input(steps[i]));
        good = show(out.effort, out.flags, steps[i][{N}_INPUTS], step_flags[i]) && good;
    }}
    for (unsigned i = 0; i < FIELDS; i++) {{
        const Command out = {class_name(step)}::inverse(input(fields[i]), number(fields[i][{N}_INPUTS]));
        good = show(out.field, out.flags, fields[i][{N}_INPUTS + 1u], field_flags[i]) && good;
    }}
    device.reset();
    for (unsigned i = 0; i < AHEAD; i++) {{
        const Command out = device.inverse_now(input(steps[i]), number(ahead[i][0]));
        good = show(out.field, out.flags, ahead[i][1], ahead_flags[i]) && good;
        device.step(input(steps[i]));
    }}
    return good ? 0 : 1;
}}
"""


def verify(step: ExportedStep, folder: Path) -> Iterator[Check]:
    """The class on the test vectors, by every C++ compiler found.

    Raises:
        ExportError: there is none.
    """
    compilers = cpp_compilers()
    if not compilers:
        raise ExportError(
            "no C++ compiler is found", where=str(folder), remedy="Install one, for example g++"
        )
    n = step.name
    vectors = vectors_of(step)
    include = folder / "include"
    code = folder / "src"
    with scratch_folder() as work:
        core = Path(work) / "core.o"
        program = Path(work) / "check"
        native().build([code / f"{n}.c"], core, "-O2", "-c", f"-I{include}", f"-I{include / n}")
        for name, command in compilers:
            strict = ("-std=c++11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", EXACT[1])
            files = (str(code / f"{n}_check.cpp"), str(core), "-o", str(program))
            words = [*command, *strict, f"-I{include}", *files]
            run(words, f"{name} cannot compile the class", "Use another compiler")
            printed = run(
                [str(program)], "the class does not give what it should", "Export the model again"
            )
            yield compare(step, vectors, f"{name}, C++11", printed)
