"""Result of a diagnosis: verdict, findings, errors, and the sentences that state them."""
