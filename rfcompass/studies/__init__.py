"""Studies: figures and tables as commands that anyone can run, resume and spread over workers."""
