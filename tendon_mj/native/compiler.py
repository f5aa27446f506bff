"""Machine code of the marked functions, by Numba: one object file for one kind of processor.

Numba types each function and writes its unoptimised code. All of it is linked here into one module,
in which only the entries are visible, and LLVM optimises that once. No `fastmath`: results must not
depend on how sums are reordered, since a resumed simulation has to repeat itself bit by bit.
"""

from __future__ import annotations

import contextlib
import functools
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from types import FunctionType
from typing import Any
from unittest import mock

import llvmlite.binding as llvm
import numba
import numpy as np
from llvmlite import ir
from numba import carray, types
from numba.core import cgutils, codegen, cpu
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_global
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_builtin,
    lower_getattr_generic,
    lower_setattr_generic,
    models,
    register_model,
    typeof_impl,
)

from tendon_mj.native import marks

_C_TYPES = {
    "void": types.void,
    "bool": types.boolean,
    "i32": types.int32,
    "i64": types.int64,
    "f64": types.float64,
    "ptr": types.intp,
}
_WORD = ir.IntType(64)
# processors that every machine of an architecture in use is at least
_BASELINES = {"x86_64": "x86-64-v2", "aarch64": "generic", "arm64": "apple-m1"}


def _signature(written: str) -> Any:
    """A signature of `marks` as Numba has it."""
    match = re.fullmatch(r"(\w+)\((.*)\)", written)
    assert match is not None, written
    names = [name.strip() for name in match[2].split(",") if name.strip()]
    returned, *given = (
        _Place(marks.Field(name)) if name in marks.STRUCTS else _C_TYPES[name]
        for name in (match[1], *names)
    )
    return returned(*given)


@functools.cache
def _dispatcher(function: Any) -> Any:
    return numba.njit(
        error_model="numpy",
        nogil=True,
        forceinline=function.is_inlined,
        no_cpython_wrapper=True,
        no_cfunc_wrapper=True,
    )(function)


@typeof_impl.register(FunctionType)
def _typeof_function(value: Any, context: Any) -> Any:
    is_marked = "is_inlined" in value.__dict__
    return types.Dispatcher(_dispatcher(value)) if is_marked else None


@typeof_impl.register(marks.External)
def _typeof_external(value: marks.External, context: Any) -> Any:
    return types.ExternalFunction(value.symbol, _signature(value.signature))


def _meaning_of(kind: type) -> Callable[[Callable[[Any], Any]], None]:
    """Let a kind of marks be, in compiled functions, what the decorated function makes of each."""

    def register(make: Callable[[Any], Any]) -> None:
        made: dict[int, Any] = {}

        @typeof_impl.register(kind)
        def typeof_mark(value: Any, context: Any) -> Any:
            if id(value) not in made:
                made[id(value)] = make(value)
                cpu_target.typing_context.refresh()
                cpu_target.target_context.refresh()
            return cpu_target.typing_context.resolve_value_type(made[id(value)])

    return register


def _at(builder: Any, address: Any, kind: Any) -> Any:
    """Pointer to a type at an address, which is an integer or a pointer itself."""
    is_pointer = isinstance(address.type, ir.PointerType)
    cast = builder.bitcast if is_pointer else builder.inttoptr
    return cast(address, kind.as_pointer())


def _as_integer(builder: Any, address: Any) -> Any:
    is_pointer = isinstance(address.type, ir.PointerType)
    return builder.ptrtoint(address, _WORD) if is_pointer else address


def _as_type(context: Any, builder: Any, address: Any, kind: Any) -> Any:
    """An address as a value of a type that stands for what is there."""
    value_type = context.get_value_type(kind)
    if isinstance(value_type, ir.PointerType):
        return _at(builder, address, value_type.pointee)
    return _as_integer(builder, address)


def _intrinsic(returned: Any, given: tuple[Any, ...], build: Callable[..., Any]) -> Any:
    """A function for compiled code: ``build(context, builder, *values)`` of ``given`` types.

    A struct or an array may be given as its address.
    """

    @intrinsic
    def operation(typing_context: Any, *arguments: Any) -> Any:
        def lower(context: Any, builder: Any, signature: Any, values: Any) -> Any:
            packed = cgutils.unpack_tuple(builder, values[0])
            cast = [
                _as_integer(builder, value)
                if isinstance(kind, _Place | types.CPointer)
                else context.cast(builder, value, kind, wanted)
                for value, kind, wanted in zip(packed, signature.args[0], given, strict=True)
            ]
            return build(context, builder, *cast)

        return returned(types.StarArgTuple(arguments)), lower

    return operation


def _operation(
    kind: type, returned: Any, *given: Any
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Let each of a kind of marks be a function: ``build(mark, context, builder, *values)``."""

    def register(build: Callable[..., Any]) -> Callable[..., Any]:
        _meaning_of(kind)(lambda mark: _intrinsic(returned, given, functools.partial(build, mark)))
        return build

    return register


def _cast_to(kind: Any) -> Any:
    """The function of an address that is a value of a type that stands for what is there."""
    return _intrinsic(
        kind,
        (types.intp,),
        lambda context, builder, address: _as_type(context, builder, address, kind),
    )


@_operation(marks.Word, types.int64, types.intp)
def _word(mark: marks.Word, context: Any, builder: Any, address: Any) -> Any:
    value = builder.load(_at(builder, address, _WORD))
    value.align = 1
    return value


@_operation(marks.Wrapping, types.int64, types.int64, types.int64)
def _wrapping(mark: marks.Wrapping, context: Any, builder: Any, a: Any, b: Any) -> Any:
    return getattr(builder, mark.instruction)(a, b)


@_operation(marks.Text, types.intp)
def _text(mark: marks.Text, context: Any, builder: Any) -> Any:
    return builder.ptrtoint(context.insert_const_string(builder.module, mark.content), _WORD)


@_operation(marks.LocalDoubles, types.intp)
def _local_doubles(mark: marks.LocalDoubles, context: Any, builder: Any) -> Any:
    numbers = cgutils.alloca_once(builder, ir.ArrayType(ir.DoubleType(), mark.count))
    return builder.ptrtoint(numbers, _WORD)


@_operation(marks.Addresses, types.intp, types.intp)
def _addresses(mark: marks.Addresses, context: Any, builder: Any, index: Any) -> Any:
    kind = ir.FunctionType(ir.VoidType(), [])
    functions = [
        cgutils.get_or_insert_function(builder.module, kind, symbol) for symbol in mark.symbols
    ]
    addresses = ir.Constant(
        ir.ArrayType(_WORD, len(functions)), [function.ptrtoint(_WORD) for function in functions]
    )
    table = cgutils.global_constant(builder, "addresses", addresses)
    return builder.load(builder.gep(table, [ir.IntType(32)(0), index]))


@_operation(marks.Shared, types.intp)
def _shared_numbers(mark: marks.Shared, context: Any, builder: Any) -> Any:
    return builder.ptrtoint(_shared(builder.module, mark.symbol, mark.count), _WORD)


@_operation(marks.Address, types.intp, types.intp)
def _address(mark: marks.Address, context: Any, builder: Any, address: Any) -> Any:
    return address


@_meaning_of(marks.Pointer)
def _pointer(mark: marks.Pointer) -> Any:
    return _cast_to(_type_of(marks.Field(mark.kind).part(1)))


@_meaning_of(marks.Array)
def _array(mark: marks.Array) -> Any:
    cast = _cast_to(types.CPointer(numba.from_dtype(mark.dtype)))

    def array(address: int, count: int) -> Any:
        return carray(cast(address), (count,))

    return _dispatcher(marks.compiled(array))


@_meaning_of(marks.Record)
def _record(mark: marks.Record) -> Any:
    # a compiled function would return a copy of the record
    return _cast_to(numba.from_dtype(mark.dtype))


def _call(context: Any, builder: Any, wanted: Any, address: Any, values: Any) -> Any:
    """Call the C function at an address, of a signature."""
    is_void = wanted.return_type == types.void
    c_result = ir.VoidType() if is_void else context.get_value_type(wanted.return_type)
    c_types = [context.get_value_type(kind) for kind in wanted.args]
    function = builder.inttoptr(address, ir.FunctionType(c_result, c_types).as_pointer())
    result = builder.call(function, values)
    return context.get_dummy_value() if is_void else result


@_meaning_of(marks.Called)
def _called(mark: marks.Called) -> Any:
    wanted = _signature(mark.signature)
    return _intrinsic(
        wanted.return_type,
        (types.intp, *wanted.args),
        lambda context, builder, address, *values: _call(context, builder, wanted, address, values),
    )


@_meaning_of(marks.EngineFunction)
def _engine_function(mark: marks.EngineFunction) -> Any:
    wanted = _signature(mark.signature)
    place = [ir.IntType(32)(0), ir.IntType(32)(marks.ENGINE.index(mark.symbol))]

    def call(context: Any, builder: Any, *values: Any) -> Any:
        array = _shared(builder.module, marks.ENGINE_ARRAY, marks.ARRAYS[marks.ENGINE_ARRAY])
        address = builder.load(builder.gep(array, place))
        return _call(context, builder, wanted, address, values)

    return _intrinsic(wanted.return_type, wanted.args, call)


def _shared(module: Any, symbol: str, count: int) -> Any:
    """The array of int64s of a symbol, in a module that uses it."""
    with contextlib.suppress(KeyError):
        return module.get_global(symbol)
    return ir.GlobalVariable(module, ir.ArrayType(_WORD, count), symbol)


def _constant(builder: Any, name: str) -> Any:
    """A number that is written before any function runs."""
    constants = next((known for known in marks.CONSTANTS if name in known.names), None)
    assert constants is not None, f"no table of offsets has {name}"
    numbers = _shared(builder.module, constants.symbol, len(constants.names))
    index = constants.names.index(name)
    place = builder.gep(numbers, [ir.IntType(32)(0), ir.IntType(32)(index)], inbounds=True)
    number = builder.load(place)
    # so that it may be read once for many uses
    number.set_metadata("invariant.load", builder.module.add_metadata([]))
    return number


class _Place(types.Type):  # type: ignore[misc]
    """A struct or an array, by its address."""

    def __init__(self, field: marks.Field) -> None:
        self.field = field
        super().__init__(f"{field}")

    def attribute(self, name: str) -> marks.Field | None:
        """A field of a struct; an array of two dimensions in one."""
        if self.field.dimensions == 0:
            return marks.STRUCTS[self.field.kind].field(name)
        return self.field.part(1) if name == "flat" and self.field.dimensions == 2 else None


@register_model(_Place)
class _PlaceModel(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, _WORD)


def _type_of(field: marks.Field) -> Any:
    if field.dimensions == 0 and field.kind not in marks.STRUCTS:
        return types.float64 if field.kind.startswith("float") else types.int64
    is_pointer = field.dimensions == 1 and field.kind == "float64"
    return types.CPointer(types.float64) if is_pointer else _Place(field)


def _read(context: Any, builder: Any, place: Any, field: marks.Field) -> Any:
    """A number at a place; of an array or struct, the place."""
    kind = _type_of(field)
    if not isinstance(kind, types.Number):
        return _as_type(context, builder, place, kind)
    stored = numba.from_dtype(np.dtype(field.kind))
    number = builder.load(_at(builder, place, context.get_data_type(stored)))
    return context.cast(builder, number, stored, kind)


def _write(
    context: Any, builder: Any, place: Any, field: marks.Field, value: Any, kind: Any
) -> Any:
    stored = numba.from_dtype(np.dtype(field.kind))
    number = context.cast(builder, value, kind, stored)
    builder.store(number, _at(builder, place, context.get_data_type(stored)))
    return context.get_dummy_value()


@infer_getattr
class _Attribute(AttributeTemplate):  # type: ignore[misc]
    key = _Place

    def generic_resolve(self, kind: Any, name: str) -> Any:
        field = kind.attribute(name)
        return None if field is None else _type_of(field)


def _in_struct(builder: Any, kind: Any, address: Any, name: str) -> Any:
    """Address of a field, or of the pointer to it."""
    entry = f"{marks.STRUCTS[kind.field.kind].prefix}_{name}"
    return builder.add(address, _constant(builder, entry))


@lower_getattr_generic(_Place)
def _lower_getattr(context: Any, builder: Any, kind: Any, address: Any, name: str) -> Any:
    field = kind.attribute(name)
    is_struct = field.dimensions == 0 and field.kind in marks.STRUCTS  # its offsets count from here
    if kind.field.dimensions == 0 and not is_struct:
        address = _in_struct(builder, kind, address, name)
        if field.dimensions > 0 and not field.is_inline:
            address = builder.load(_at(builder, address, _WORD))
    return _read(context, builder, address, field)


@lower_setattr_generic(_Place)
def _lower_setattr(context: Any, builder: Any, signature: Any, arguments: Any, name: str) -> None:
    kind, given = signature.args
    place = _in_struct(builder, kind, arguments[0], name)
    _write(context, builder, place, kind.attribute(name), arguments[1], given)


class _Item(AbstractTemplate):  # type: ignore[misc]
    """An index into an array: a number, or as many as there are dimensions."""

    def generic(self, args: Any, kws: Any) -> Any:
        array, index, *value = args
        if not isinstance(array, _Place):
            return None
        given = len(index) if isinstance(index, types.BaseTuple) else 1
        kind = types.UniTuple(types.int64, given) if given > 1 else types.int64
        part = _type_of(array.field.part(array.field.dimensions - given))
        return types.none(array, kind, part) if value else part(array, kind)


infer_global(operator.getitem)(_Item)
infer_global(operator.setitem)(_Item)


def _in_array(builder: Any, field: marks.Field, address: Any, index: Any) -> tuple[Any, Any]:
    """Pointer to what an index means, and what that is."""
    is_one = isinstance(index.type, ir.IntType)
    row, *columns = [index] if is_one else cgutils.unpack_tuple(builder, index)
    size = _constant(builder, field.row) if isinstance(field.row, str) else _WORD(field.row)
    place = builder.gep(_at(builder, address, ir.IntType(8)), [builder.mul(size, row)])
    for column in columns:
        size = _WORD(np.dtype(field.kind).itemsize)
        place = builder.gep(place, [builder.mul(size, column)])
    return place, field.part(field.dimensions - 1 - len(columns))


@lower_builtin(operator.getitem, _Place, types.Any)
def _lower_getitem(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _read(context, builder, *_in_array(builder, signature.args[0].field, *arguments))


@lower_builtin(operator.setitem, _Place, types.Any, types.Any)
def _lower_setitem(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    place = _in_array(builder, signature.args[0].field, *arguments[:2])
    return _write(context, builder, *place, arguments[2], signature.args[2])


@contextlib.contextmanager
def _unoptimised() -> Iterator[None]:
    """Let Numba write the code of functions without optimising, linking or loading it."""

    def finalize(library: Any) -> None:
        library._finalized = True

    def executable(context: Any, library: Any, descriptor: Any, environment: Any) -> Any:
        return cpu._dynfunc.make_function(
            descriptor.lookup_module(), descriptor.qualname, "", 1, environment, (library,)
        )

    library = codegen.CPUCodeLibrary
    with (
        mock.patch.object(library, "_optimize_functions"),
        mock.patch.object(library, "finalize", finalize),
        mock.patch.object(cpu.CPUContext, "get_executable", executable),
        mock.patch.object(numba.config, "DISABLE_JIT", 0),
    ):
        yield


def _entry_module(symbol: str, signature: Any, result: Any) -> Any:
    """A module with a C function that calls a compiled function."""
    context = cpu_target.target_context
    module = ir.Module(f"entry {symbol}")
    returned = signature.return_type
    c_types = [context.get_data_type(kind) for kind in signature.args]
    c_result = ir.VoidType() if returned == types.void else context.get_data_type(returned)
    function = ir.Function(module, ir.FunctionType(c_result, c_types), symbol)
    builder = ir.IRBuilder(function.append_basic_block())
    callee = context.declare_function(module, result.fndesc)
    arguments = [
        context.data_model_manager[kind].from_data(builder, value)
        for kind, value in zip(signature.args, function.args, strict=True)
    ]
    _, value = context.call_conv.call_function(
        builder, callee, result.fndesc.restype, signature.args, arguments
    )
    if returned == types.void:
        builder.ret_void()
    else:
        value = context.cast(builder, value, result.fndesc.restype, returned)
        builder.ret(context.data_model_manager[returned].as_data(builder, value))
    return module


# Numba counts references to arrays; all of these share memory that is not Python's
_UNCOUNTED = """
define void @NRT_incref(ptr %0) alwaysinline { ret void }
define void @NRT_decref(ptr %0) alwaysinline { ret void }
"""


_CONSTRUCTED = f"""
@llvm.global_ctors = appending global [1 x {{ i32, ptr, ptr }}]
    [{{ i32, ptr, ptr }} {{ i32 65535, ptr @{marks.CONSTRUCTOR}, ptr null }}]
declare void @{marks.CONSTRUCTOR}()
"""


def _linked(entries: Mapping[str, marks.Entry], empty: str) -> Any:
    """Unoptimised module of the entries and all that they call, in which only they are visible."""
    whole = llvm.parse_assembly(empty + _UNCOUNTED)
    libraries: dict[Any, None] = {}  # in the order in which they were met

    def add(library: Any) -> None:
        if library not in libraries and library.name != "nrt":
            libraries[library] = None
            for other in library._linking_libraries:
                add(other)

    for symbol, entry in entries.items():
        signature = _signature(entry.signature)
        dispatcher = _dispatcher(marks.compiled(entry.function))
        dispatcher.compile(signature.args)
        result = dispatcher.overloads[signature.args]
        add(result.library)
        whole.link_in(llvm.parse_assembly(str(_entry_module(symbol, signature, result))))
    for library in libraries:
        whole.link_in(library._final_module, preserve=True)
    if marks.CONSTRUCTOR in entries:  # which runs when the library is loaded
        whole.link_in(llvm.parse_assembly(_CONSTRUCTED))
    numbers = "".join(
        f"@{k} = global [{n} x i64] zeroinitializer\n" for k, n in marks.ARRAYS.items()
    )
    whole.link_in(llvm.parse_assembly(numbers))
    for value in (*whole.functions, *whole.global_variables):
        is_visible = (
            value.name in entries or value.name in marks.ARRAYS or value.name.startswith("llvm.")
        )
        if not value.is_declaration and not is_visible:
            value.linkage = "internal"
    return whole


@global_compiler_lock
def compile_object(
    entries: Mapping[str, marks.Entry], triple: str = "", cpu_name: str = ""
) -> bytes:
    """Object file with the entries and all that they call.

    Args:
        entries: symbol → function.
        triple: of the machine; empty: this one.
        cpu_name: LLVM's name of the least processor that it has to run on; empty: the baseline of
            the architecture.
    """
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    triple = triple or llvm.get_process_triple()
    machine = llvm.Target.from_triple(triple).create_target_machine(
        cpu=cpu_name or _BASELINES.get(triple.split("-")[0], ""), opt=3, reloc="pic"
    )
    if "windows" in triple:  # where the C library has no symbols by name
        entries = {k: entry for k, entry in entries.items() if k != marks.CONSTRUCTOR}
    empty = f'target triple = "{triple}"\ntarget datalayout = "{machine.target_data}"\n'
    with _unoptimised():
        whole = _linked(entries, empty)
    builder = llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(speed_level=3))
    builder.getModulePassManager().run(whole, builder)
    machine_code: bytes = machine.emit_object(whole)
    return machine_code
