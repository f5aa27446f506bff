"""Machine code of the plugins: which functions are compiled, by what, and where the result is."""

from tendon_mj.native.library import FOLDER as FOLDER
from tendon_mj.native.library import Library as Library
from tendon_mj.native.library import load as load
from tendon_mj.native.marks import ARRAYS as ARRAYS
from tendon_mj.native.marks import CONSTRUCTOR as CONSTRUCTOR
from tendon_mj.native.marks import ENGINE as ENGINE
from tendon_mj.native.marks import ENGINE_ARRAY as ENGINE_ARRAY
from tendon_mj.native.marks import Address as Address
from tendon_mj.native.marks import AddressOf as AddressOf
from tendon_mj.native.marks import Array as Array
from tendon_mj.native.marks import Called as Called
from tendon_mj.native.marks import Constants as Constants
from tendon_mj.native.marks import EngineFunction as EngineFunction
from tendon_mj.native.marks import External as External
from tendon_mj.native.marks import Field as Field
from tendon_mj.native.marks import LocalDoubles as LocalDoubles
from tendon_mj.native.marks import Pointer as Pointer
from tendon_mj.native.marks import Record as Record
from tendon_mj.native.marks import Shared as Shared
from tendon_mj.native.marks import Struct as Struct
from tendon_mj.native.marks import Text as Text
from tendon_mj.native.marks import Word as Word
from tendon_mj.native.marks import Wrapping as Wrapping
from tendon_mj.native.marks import apart as apart
from tendon_mj.native.marks import compiled as compiled
from tendon_mj.native.marks import entry as entry
