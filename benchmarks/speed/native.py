"""Pinocchio in C++, and Pinocchio traced by CasADi into C: built from the headers in the wheels, called by ctypes.

Building takes some minutes, once; results are kept beside the cache of kernels.
"""

from __future__ import annotations

import ctypes
import hashlib
import shutil
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, files, version
from pathlib import Path

import numpy as np

from benchmarks.speed.arms import Arm, Array
from symdyn.emit.kernel import cache_root

HERE = Path(__file__).parent
FUNCTIONS = ("inverse_dynamics", "mass_matrix", "forward_dynamics", "forward_dynamics_state_jacobian")
DEFINES = (  # as pinocchio's own CMake files ask for
    "BOOST_MPL_LIMIT_LIST_SIZE=30",
    "BOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "BOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "BOOST_FUSION_INVOKE_MAX_ARITY=12",
    "NDEBUG",
)
CPP, CASADI = "Pinocchio C++", "Pinocchio + CasADi C"
C_BUILDS = (
    ("gcc", "-O3 -march=native"),
    ("gcc", "-O3 -march=native -ffast-math"),
    ("clang", "-O3 -march=native -ffast-math"),
)
LOOP = """
void loop_{0}(void* none, long count, const double* q, const double* qd, const double* third, double* out)
{{
    (void)none;
    for (long k = 0; k < count; ++k, q += {1}, qd += {1}, third += {1}, out += {2}) {{
        const double* arguments[] = {{q, qd, third}};
        {0}(arguments, &out, 0, 0, 0);
    }}
}}
"""
Loop = Callable[[Array, Array, Array, Array], None]  # q, qd, qdd or tau, out; a row per state


class Unavailable(Exception):
    """A rival cannot be built here; the text says why."""


@dataclass(frozen=True)
class Rival:
    """One build of one rival: ``loops[function]`` computes every row, of the functions that are compared."""

    kind: str  # CPP or CASADI
    build: str
    loops: dict[str, Loop]


def rivals(arm: Arm) -> Iterator[Rival | Unavailable]:
    """Every build that this machine can make, and what it cannot."""
    for make in (_cpp, _casadi):
        try:
            yield from make(arm)
        except Unavailable as why:
            yield why


def _cpp(arm: Arm) -> Iterator[Rival]:
    compilers = [name for name in ("g++", "clang++") if shutil.which(name)]
    if not compilers:
        raise Unavailable(f"{CPP}: neither g++ nor clang++ is installed")
    for compiler in compilers:
        flags = ["-O3", "-march=native", "-shared", "-fPIC"]
        library = ctypes.CDLL(str(_built(compiler, "pinocchio_loop.cpp", flags)))
        library.arm_new.restype = ctypes.c_void_p
        for local, where in enumerate(("world frame", "joint frames")):
            numbers = np.ascontiguousarray(arm.numbers)
            made = ctypes.c_void_p(library.arm_new(arm.joints, _at(arm.gravity), _at(numbers), local))
            loops = {name: _loop(library, name, made) for name in FUNCTIONS}
            yield Rival(CPP, f"{compiler} -O3 -march=native, {where}", loops)


def _casadi(arm: Arm) -> Iterator[Rival]:
    source = _traced(arm)
    builds = [(compiler, flags) for compiler, flags in C_BUILDS if shutil.which(compiler)]
    if not builds:
        raise Unavailable(f"{CASADI}: neither gcc nor clang is installed")
    for compiler, flags in builds:
        library = source.with_name(f"{source.stem}-{compiler}{flags.replace(' ', '')}.so")
        if not library.exists():
            _run([compiler, *flags.split(), "-shared", "-fPIC", "-o", str(library), str(source), "-lm"])
        loaded = ctypes.CDLL(str(library))
        loops = {name: _loop(loaded, f"loop_{name}", ctypes.c_void_p(None)) for name in FUNCTIONS}
        yield Rival(CASADI, f"{compiler} {flags}", loops)


def _traced(arm: Arm) -> Path:
    """The C that CasADi writes for one arm, with its option `cse`, and loops over states."""
    library = next((f for f in _package("casadi") if f.name.startswith("libcasadi.so.")), None)
    if library is None:
        raise Unavailable(f"{CASADI}: the wheel of casadi has no libcasadi.so here")
    folder = library.parent
    link = ["-isystem", str(folder / "include"), str(library), f"-Wl,-rpath,{folder}"]
    tracer = _built("g++", "casadi_trace.cpp", ["-O0", *link])
    numbers = [arm.joints, *arm.gravity.tolist(), *arm.numbers.ravel().tolist()]
    text = " ".join(map(repr, numbers))
    source = _folder() / f"{arm.name}-{_key(text, tracer.name)}.c"
    if not source.exists():
        given = source.with_suffix(".txt")
        given.write_text(text, encoding="utf-8")
        _run([str(tracer), str(given), f"{_folder()}/"])
        traced = _folder() / "traced.c"
        n = arm.joints
        sizes = {"mass_matrix": n * n, "forward_dynamics_state_jacobian": 2 * n * n}
        loops = "".join(LOOP.format(name, n, sizes.get(name, n)) for name in FUNCTIONS)
        source.write_text(traced.read_text(encoding="utf-8") + loops, encoding="utf-8")
    return source


def _built(compiler: str, source: str, flags: list[str]) -> Path:
    """A C++ file of this folder, compiled against the headers of the wheels of pin and cmeel-eigen."""
    if not shutil.which(compiler):
        raise Unavailable(f"{source}: {compiler} is not installed")
    eigen = _header("cmeel-eigen", "eigen3/Eigen/Core").parent.parent
    headers = [_header("libpinocchio", "include/pinocchio/multibody.hpp").parent.parent, eigen]
    includes = [part for folder in headers for part in ("-isystem", str(folder))]
    defines = [f"-D{define}" for define in DEFINES]
    text = "".join((HERE / name).read_text(encoding="utf-8") for name in (source, "chain.hpp"))
    versions = f"{version('libpinocchio')} {version('cmeel-eigen')}"
    target = _folder() / f"{Path(source).stem}-{_key(text, compiler, *flags, versions)}"
    if not target.exists():
        print(f"building {source} with {compiler} (some minutes, once)", flush=True)
        # Libraries follow the source that needs them.
        _run([compiler, "-std=c++17", *defines, *includes, str(HERE / source), *flags, "-o", str(target)])
    return target


def _header(package: str, end: str) -> Path:
    found = next((f for f in _package(package) if str(f).endswith(end)), None)
    if found is None:
        raise Unavailable(f"the wheel of {package} has no {end}")
    return found


def _package(name: str) -> list[Path]:
    try:
        return [Path(str(f.locate())) for f in files(name) or ()]
    except PackageNotFoundError:
        raise Unavailable(f"{name} is not installed: pip install '.[bench]'") from None


def _run(command: list[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        lines = [line for line in done.stderr.split("\n") if "error" in line] or done.stderr.split("\n")
        raise Unavailable(f"{Path(command[0]).name} failed: {lines[0][:300]}")


def _loop(library: ctypes.CDLL, name: str, arm: ctypes.c_void_p) -> Loop:
    function = getattr(library, name)
    function.restype = None

    def loop(q: Array, qd: Array, third: Array, out: Array) -> None:
        function(arm, ctypes.c_long(len(q)), _at(q), _at(qd), _at(third), _at(out))

    return loop


def _at(array: Array) -> ctypes.c_void_p:
    if not array.flags.c_contiguous or array.dtype != np.float64:
        raise ValueError("the loops read contiguous float64")
    return ctypes.c_void_p(array.ctypes.data)


def _folder() -> Path:
    folder = cache_root() / "bench"
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return folder


def _key(*texts: str) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()[:16]
