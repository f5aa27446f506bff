"""One effect a file; `tendon_mj.diagnosis.catalogue` lists them."""
