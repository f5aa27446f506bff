"""A spool at the input of a tendon, turned by the motor that pulled the tendon before."""

from tendon_mj.attach.spool.add import add_spools as add_spools
from tendon_mj.attach.spool.add import spool_names as spool_names
from tendon_mj.attach.spool.design import SpoolDesign as SpoolDesign
from tendon_mj.attach.spool.design import design_spool as design_spool
from tendon_mj.attach.spool.remove import SpoolOnTendon as SpoolOnTendon
from tendon_mj.attach.spool.remove import remove_spools as remove_spools
from tendon_mj.attach.spool.remove import spools_by_tendon as spools_by_tendon
from tendon_mj.attach.spool.spool import Spool as Spool
