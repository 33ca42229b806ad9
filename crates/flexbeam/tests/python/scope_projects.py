"""A project's page: laid out anew, saved from the page, and there again in the next run."""
