//! Errors of which nobody asks for the cause: the message is all that goes on.

/// Lets `?` turn errors into the message of another one: `from_messages!(SetError as SetError: Faults, Fault)`, with the type, how it is made of a message, and the errors.
#[macro_export]
#[doc(hidden)]
macro_rules! __from_messages {
    ($error:ty as $of:path: $($source:ty),+ $(,)?) => {
        $(impl From<$source> for $error {
            fn from(error: $source) -> Self {
                $of(error.to_string())
            }
        })+
    };
}

pub use __from_messages as from_messages;
